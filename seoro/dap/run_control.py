"""`RunControl`: one scenario that runs with a debugger."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AsyncExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from seoro.dap.launch import Launch
from seoro.dap.output import writing_trace
from seoro.embed.api import start_with
from seoro.embed.debug_expressions import condition, watched
from seoro.embed.picture_server import serving_pictures
from seoro.embed.runs import Run
from seoro.embed.scenarios import Scenario, load
from seoro.errors import InvalidScenario, SeoroError
from seoro.lang.frozen import Value
from seoro.lang.plan import Plan
from seoro.runtime.debug.breakpoints import Breakpoint
from seoro.runtime.debug.debugger import Debugger
from seoro.runtime.execution.context import BehaviorScope
from seoro.runtime.execution.static_tree import behaviors_of_plan
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.trace.records import write_error_text
from seoro.runtime.values.environment import EvaluationError
from seoro.runtime.values.text import value_text
from seoro.runtime.values.values import Value as RunValue
from seoro.runtime.verdict import Verdict

_IN_REACTION: Final = "reactions have no pauses: they are effects of an instant"


class Requested(Value):
    """A breakpoint that the editor asks for.

    Args:
        line: Its line, from 1.
        condition: Its condition, or an empty text.
    """

    line: int
    condition: str = ""


class Placed(Value):
    """Result of a requested breakpoint.

    Args:
        line: Line at which the run will pause; None if it never will.
        message: Reason why it was moved or refused; empty for none.
    """

    line: int | None
    message: str = ""


class RunControl:
    """A scenario file, and its run.

    Args:
        launch: Settings of the run.

    Raises:
        SeoroError: The file has errors, or cannot be run with these settings.
    """

    def __init__(self, launch: Launch) -> None:
        self.scenario: Scenario = load(launch.file)
        self.debugger = Debugger(stop_on_entry=launch.stop_on_entry)
        self._options = launch.options(self.debugger)
        self.plan: Plan = self.scenario.plan(self._options.name, {})
        self._run: Run | None = None
        self._behaviors = list(behaviors_of_plan(self.plan))  # with the names of their scenarios

    async def run(self, observer: Callable[[Mapping[str, Any]], object]) -> Verdict:
        """Run to the end.

        Args:
            observer: Called with each record of the trace.

        Raises:
            SeoroError: The run cannot start.
        """
        folder = self._options.output_directory
        async with AsyncExitStack() as opened:
            traces = () if folder is None else (await opened.enter_async_context(writing_trace(folder)),)
            options = replace(self._options, observers=(_Observer(observer), *traces), timeout=math.inf)
            run = await opened.enter_async_context(start_with(self.scenario, options, "timeout"))
            self._run = run
            if folder is not None and run.simulator is not None:
                await opened.enter_async_context(serving_pictures(run.simulator, folder))
            loop = asyncio.get_running_loop()
            for trace in traces:
                trace.on_error = lambda error: loop.call_soon_threadsafe(run.abort, write_error_text(error))
            return await run.result()

    def stop(self) -> None:
        """Cancel the run, if it is active."""
        self.debugger.release()
        if self._run is not None:
            self._run.stop("stopped by the debugger")

    # -------------------------------------------------------- breakpoints

    def set_breakpoints(self, path: Path, requested: Sequence[Requested]) -> list[Placed]:
        """Replace the breakpoints of a file.

        Args:
            path: The file.
            requested: The breakpoints.
        """
        file = path.resolve()
        lines = {
            behavior.span.line: owner
            for owner, behavior in reversed(self._behaviors)
            if self.debugger.breakpoints.path_of(behavior.span) == file
        }
        reactions = self._reaction_lines(file) - lines.keys()
        found: dict[int, Breakpoint] = {}
        placed = [
            Placed(None, _IN_REACTION) if each.line in reactions else self._place(each, lines, found)
            for each in requested
        ]
        self.debugger.breakpoints.replace(file, found)
        return placed

    def _reaction_lines(self, file: Path) -> set[int]:
        """Return the lines of the reactions in a file."""
        found: set[int] = set()
        for scenario in self.plan.scenarios.values():
            for reaction in scenario.on:
                if self.debugger.breakpoints.path_of(reaction.span) == file:
                    found.update(range(reaction.span.line, reaction.members[-1].span.line + 1))
        return found

    def _place(self, requested: Requested, lines: Mapping[int, str], found: dict[int, Breakpoint]) -> Placed:
        line = min((line for line in lines if line >= requested.line), default=None)
        if line is None:
            return Placed(None, "no behavior of the scenario starts in this line or below it")
        expression = None
        if requested.condition:
            try:
                expression = condition(self.scenario, lines[line], requested.condition)
            except InvalidScenario as error:
                return Placed(None, f"invalid condition: {error.diagnostics[0].message}")
        found[line] = Breakpoint(line, expression)
        return Placed(line)

    # -------------------------------------------------------- values

    def evaluate(self, text: str, scope: BehaviorScope) -> tuple[RunValue, str]:
        """Evaluate an expression where a behavior runs; return the value, and its text.

        Raises:
            SeoroError: The expression is invalid, or has no value.
        """
        expression, type_ = watched(self.scenario, scope.context.instance.declaration.name, text)
        try:
            value = evaluate(expression, scope.context.environment())
        except EvaluationError as error:
            raise SeoroError(f"`{text}` has no value: {error}") from error
        return value, value_text(value, type_, self.plan.structures)


class _Observer:
    """Observer of the trace that passes records on."""

    def __init__(self, notify: Callable[[Mapping[str, Any]], object]) -> None:
        self._notify = notify

    def record(self, record: dict[str, Any]) -> None:
        self._notify(record)
