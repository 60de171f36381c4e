"""Route of the debugger: a page is the client of a debug adapter, `seoro dap`, which the site runs for it.

A page launches a file of the list of scenarios. The site adds the folder for the trace, and reports the run by the
event `seoro/run` before it answers.
"""

from __future__ import annotations

import json
import secrets
import shutil
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import anyio
import anyio.to_thread
from starlette.routing import BaseRoute, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from seoro.runtime.execution.outputs import TRACE
from seoro.ui.answers import RequestError, as_request_error
from seoro.ui.debug_relay import Adapter, start_adapter
from seoro.ui.local_runs import describe
from seoro.ui.registry import Known, LocalSource, Run, Status, local_id
from seoro.ui.site import Site

MOST_SESSIONS: Final = 4  # at a time
MOST_KEPT: Final = 20  # results of debugged runs
PLACE: Final = "debugger"
RUN_EVENT: Final = "seoro/run"
_FOLDER: Final = "debugged"  # in the state folder of the site
_ENDS: Final = ("terminated", "exited")  # events after the end of a run


def routes(site: Site) -> list[BaseRoute]:
    """Return the route of the debugger."""
    room = anyio.Semaphore(MOST_SESSIONS)

    async def debug(socket: WebSocket) -> None:
        await socket.accept()
        try:
            site.rights.check_owner()
            _acquire(room)
        except RequestError as error:
            await socket.send_text(json.dumps(error.data))
            await socket.close()
            return
        try:
            async with start_adapter() as adapter:
                await _Session(site, socket, adapter).relay()
        finally:
            room.release()

    return [WebSocketRoute("/api/debug", debug)]


def _acquire(room: anyio.Semaphore) -> None:
    """Take a place for a session.

    Raises:
        RequestError: All places are taken.
    """
    try:
        room.acquire_nowait()
    except anyio.WouldBlock:
        raise RequestError(503, "too many debugged runs", f"end one of the {MOST_SESSIONS} first") from None


class _Session:
    """One session of debugging: relays messages between a page and its adapter.

    Args:
        site: The site.
        socket: Connection of the page.
        adapter: Its adapter.
    """

    def __init__(self, site: Site, socket: WebSocket, adapter: Adapter) -> None:
        self._site = site
        self._socket = socket
        self._adapter = adapter
        self._launch: object = None  # number of the request
        self._trace: Path | None = None
        self._run: Run | None = None
        self._program = Path()
        self._is_registered = False
        self._active = ExitStack()

    async def relay(self) -> None:
        """Relay messages until the page or the adapter has ended."""
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._from_page, tasks)
                while (message := await self._adapter.receive()) is not None:
                    await self._to_page(message)
                tasks.cancel_scope.cancel()
        except* WebSocketDisconnect:
            pass
        finally:
            self._active.close()
            await self._adapter.end()
            await self._end_run()

    async def _from_page(self, tasks: anyio.abc.TaskGroup) -> None:
        try:
            while True:
                await self._take(await self._socket.receive_text())
        except (WebSocketDisconnect, KeyError):  # closed, or a binary message
            tasks.cancel_scope.cancel()

    async def _take(self, text: str) -> None:
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            message = None
        if not isinstance(message, dict):
            error = RequestError(400, "invalid message", "expected a request of the Debug Adapter Protocol")
            await self._socket.send_text(json.dumps(error.data))
            return
        if message.get("command") == "launch":
            try:
                message = {**message, "arguments": await self._launched(message.get("arguments"))}
            except RequestError as error:
                await self._socket.send_text(json.dumps(error.data))
                return
            self._launch = message.get("seq")
        await self._adapter.send(message)

    async def _launched(self, arguments: object) -> Mapping[str, Any]:
        """Complete the settings of a run: absolute paths, and a folder for the results.

        Raises:
            RequestError: The file is not in the list of scenarios.
        """
        if self._is_registered:
            raise RequestError(409, "the session has a run already", "start another session")
        given = arguments if isinstance(arguments, dict) else {}
        found = {name: value for name, value in given.items() if value not in (None, "")}
        name = str(found.get("program", ""))
        program = await anyio.to_thread.run_sync(self._site.scenarios.path, name)
        try:
            output = await anyio.to_thread.run_sync(_new_folder, self._site.state / _FOLDER)
        except OSError as error:
            raise as_request_error(error) from error
        self._trace, self._program = output / TRACE, program
        self._run = Run(
            id=local_id(self._trace),
            place=PLACE,
            kind="folder",
            scenario=str(found.get("scenario", "")),
            file=name,
            status=Status.RUNNING,
            started=time.time(),
            folder=str(output),
        )
        return {**found, "program": str(program), "cwd": str(program.parent), "output": str(output)}

    async def _to_page(self, message: Mapping[str, Any]) -> None:
        is_launched = message.get("type") == "response" and message.get("request_seq") == self._launch
        if is_launched and message.get("success") and self._run is not None and self._trace is not None:
            self._is_registered = True
            self._site.runs.update([Known(self._run, LocalSource(self._trace, self._trace.parent))])
            name = f"the debugged run of {self._run.file}"
            self._active.enter_context(self._site.own_runs.active(name, self._adapter.stop))
            body = {"run": self._run.id, "program": str(self._program), "cwd": str(self._program.parent)}
            await self._socket.send_text(json.dumps({"seq": 0, "type": "event", "event": RUN_EVENT, "body": body}))
        if message.get("event") in _ENDS:
            self._active.close()
            await self._end_run()
        await self._socket.send_text(json.dumps(message))

    async def _end_run(self) -> None:
        """Update the run from its trace, which has ended."""
        if not self._is_registered or self._run is None or self._trace is None or self._run.status.is_final:
            return
        try:
            found = await anyio.to_thread.run_sync(describe, self._trace, self._site.folders)
        except OSError:  # the run did not start
            found = replace(self._run, status=Status.CANCELLED)
        if not found.status.is_final:
            found = replace(found, status=Status.KILLED)
        self._run = replace(found, place=PLACE, file=self._run.file)
        self._site.runs.update([Known(self._run, LocalSource(self._trace, self._trace.parent))])


def _new_folder(parent: Path) -> Path:
    """Make a folder for the results of a run; the oldest ones are deleted.

    Raises:
        OSError: It cannot be made.
    """
    parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    before = sorted(parent.iterdir(), key=lambda path: path.stat().st_mtime)
    for path in before[: -MOST_KEPT + 1]:
        shutil.rmtree(path, ignore_errors=True)
    folder = parent / secrets.token_hex(8)
    folder.mkdir(mode=0o700)
    return folder
