"""`Session`: the requests of one editor, and the events of the run that it debugs."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from seoro.dap.connection import Connection
from seoro.dap.launch import read_launch
from seoro.dap.run_control import Requested, RunControl
from seoro.dap.views import Views
from seoro.errors import InvalidScenario, SeoroError, UsageError
from seoro.runtime.debug.debugger import Pause, Reason, Step
from seoro.runtime.explain.reasons import reason_text

_CAPABILITIES: Final = {
    "supportsConfigurationDoneRequest": True,
    "supportsConditionalBreakpoints": True,
    "supportsEvaluateForHovers": True,
    "supportsTerminateRequest": True,
}
_STEPS: Final = {"next": Step.OVER, "stepIn": Step.INTO, "stepOut": Step.OUT}
_NAMED_STEPS: Final = {"record": Step.RECORD, "instant": Step.INSTANT}
_TEXTS: Final = {
    Reason.ENTRY: "Paused at the start",
    Reason.BREAKPOINT: "Paused at a breakpoint",
    Reason.STEP: "Paused after a step",
    Reason.PAUSE: "Paused",
}
_Arguments = Mapping[str, Any]


class Session:
    """One session of debugging, from `initialize` to `disconnect`.

    Args:
        connection: Connection with the editor.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._control: RunControl | None = None
        self._views: Views | None = None
        self._run: asyncio.Task[None] | None = None
        self._is_over = False
        self._first_line = 1  # number of the first line, and of the first column, for the editor
        self._handlers: Mapping[str, Callable[[_Arguments], Mapping[str, Any] | None]] = {
            "initialize": self._initialize,
            "launch": self._launch,
            "setBreakpoints": self._set_breakpoints,
            "setExceptionBreakpoints": lambda _: None,
            "configurationDone": self._begin,
            "threads": lambda _: self._shown.threads(),
            "stackTrace": lambda arguments: self._shown.stack(int(arguments["threadId"])),
            "scopes": lambda arguments: self._shown.scopes(int(arguments["frameId"])),
            "variables": lambda arguments: self._shown.variables(int(arguments["variablesReference"])),
            "evaluate": self._evaluate,
            "continue": lambda _: self._continue(Step.NONE),
            "seoro/step": self._step_to,
            "pause": self._pause,
            "terminate": self._stop,
            "disconnect": self._disconnect,
            **{name: self._stepper(step) for name, step in _STEPS.items()},
        }

    async def serve(self) -> None:
        """Answer requests until the editor disconnects; then the run has ended.

        Raises:
            InvalidMessage: The editor does not follow the protocol.
        """
        try:
            while not self._is_over and (request := await self._connection.receive()) is not None:
                self._handle(request)
                await self._connection.drain()
        finally:
            if self._control is not None:
                self._control.stop()
            if self._run is not None:
                await self._run
            await self._connection.drain()

    def _handle(self, request: Mapping[str, Any]) -> None:
        command, arguments = request.get("command"), request.get("arguments") or {}
        if request.get("type") != "request" or not isinstance(command, str):
            return
        handler = self._handlers.get(command)
        if handler is None:
            self._connection.refuse(request, f"unsupported request `{command}`")
            return
        try:
            body = handler(arguments)
        except InvalidScenario as error:
            self._refuse_scenario(request, error)
        except SeoroError as error:
            self._connection.refuse(request, str(error))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            self._connection.refuse(request, f"invalid arguments of `{command}`: {error!r}")
        else:
            self._connection.answer(request, body)
            if command == "launch":
                self._connection.event("initialized")

    def _refuse_scenario(self, request: Mapping[str, Any], error: InvalidScenario) -> None:
        """Print all errors of a scenario, and answer with the first one."""
        first, *others = error.diagnostics
        if request.get("command") == "launch":
            self._print(f"{error}\n", "stderr")
        more = f", and {len(others)} more" if others else ""
        self._connection.refuse(request, f"{first.message}{more}")

    # -------------------------------------------------------- start and end

    def _initialize(self, arguments: _Arguments) -> Mapping[str, Any]:
        self._first_line = 1 if arguments.get("linesStartAt1", True) else 0
        return _CAPABILITIES

    def _launch(self, arguments: _Arguments) -> None:
        if self._control is not None:
            raise UsageError("the session has a scenario already", help="start another session")
        launch, warnings = read_launch(arguments)
        for warning in warnings:
            self._print(f"{warning}\n", "important")
        self._control = RunControl(launch)
        if arguments.get("noDebug"):  # "run without debugging"
            self._control.debugger.release()
        self._control.debugger.on_pause = self._paused
        self._control.debugger.breakpoints.on_error = lambda message: self._print(f"{message}\n", "stderr")
        self._views = Views(self._control, self._first_line)

    def _begin(self, arguments: _Arguments) -> None:
        if self._run is not None:
            raise UsageError("the run has begun already")
        self._run = asyncio.get_running_loop().create_task(self._carry_out())

    async def _carry_out(self) -> None:
        """Run the scenario, and report its end."""
        status = 2
        try:
            verdict = await self._controlled.run(self._record)
            status = 0 if verdict.passed else 1
            text = f"{verdict.status.value} after {verdict.duration:.3f} s\n{reason_text(verdict)}"
            self._print(f"{text.strip()}\n", "console")
        except SeoroError as error:
            self._print(f"{error}\n", "stderr")
        finally:
            self._connection.event("exited", {"exitCode": status})
            self._connection.event("terminated")
            await self._connection.drain()

    def _stop(self, arguments: _Arguments) -> None:
        if self._control is not None:
            self._control.stop()

    def _disconnect(self, arguments: _Arguments) -> None:
        self._stop(arguments)
        self._is_over = True

    @property
    def _controlled(self) -> RunControl:
        if self._control is None:
            raise UsageError("no scenario; `launch` comes first")
        return self._control

    @property
    def _shown(self) -> Views:
        if self._views is None:
            raise UsageError("no scenario; `launch` comes first")
        return self._views

    # -------------------------------------------------------- breakpoints and steps

    def _set_breakpoints(self, arguments: _Arguments) -> Mapping[str, Any]:
        path = Path(str(arguments["source"]["path"]))
        wanted: Sequence[Mapping[str, Any]] = arguments.get("breakpoints") or ()
        shift = 1 - self._first_line
        requested = [Requested(int(each["line"]) + shift, str(each.get("condition") or "")) for each in wanted]
        found = []
        for asked, placed in zip(requested, self._controlled.set_breakpoints(path, requested), strict=True):
            line = (placed.line or asked.line) - shift
            message = {"message": placed.message} if placed.message else {}
            found.append({"verified": placed.line is not None, "line": line, **message})
        return {"breakpoints": found}

    def _continue(self, step: Step) -> Mapping[str, Any]:
        debugger = self._controlled.debugger
        if debugger.pause_state is None:
            raise UsageError("the run is not paused")
        self._shown.forget()
        debugger.resume(step)
        return {"allThreadsContinued": True}

    def _stepper(self, step: Step) -> Callable[[_Arguments], Mapping[str, Any] | None]:
        def act(arguments: _Arguments) -> None:
            self._continue(step)

        return act

    def _step_to(self, arguments: _Arguments) -> None:
        """Step to the next record or instant, a request of its own."""
        target = str(arguments.get("to"))
        if target not in _NAMED_STEPS:
            raise UsageError(f"cannot step to `{target}`; expected `record` or `instant`")
        self._continue(_NAMED_STEPS[target])

    def _pause(self, arguments: _Arguments) -> None:
        self._controlled.debugger.pause()

    def _paused(self, pause: Pause) -> None:
        reason = "step" if pause.reason is Reason.STEP else pause.reason.value
        text = f"{_TEXTS[pause.reason]}, {pause.time:.3f} s"
        thread = self._shown.thread_of(pause)
        body = {"reason": reason, "description": text, "threadId": thread, "allThreadsStopped": True}
        self._connection.event("stopped", body)

    # -------------------------------------------------------- values and output

    def _evaluate(self, arguments: _Arguments) -> Mapping[str, Any]:
        text = str(arguments["expression"])
        scope = self._shown.scope_of(arguments.get("frameId"))
        value, shown = self._controlled.evaluate(text, scope)
        return {"result": shown, "variablesReference": self._shown.reference_of(value)}

    def _record(self, record: Mapping[str, Any]) -> None:
        """Print the logs of the run."""
        if record["kind"] == "log":
            level = record["level"]
            text = record["message"] if level == "info" else f"{level}: {record['message']}"
            self._print(f"{record['t']:9.3f} s  {text}\n", "stderr" if level == "error" else "stdout")

    def _print(self, text: str, category: str) -> None:
        self._connection.event("output", {"category": category, "output": text})
