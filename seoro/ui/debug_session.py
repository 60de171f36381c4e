"""`DebugSession`: relays messages between a debug adapter and the page that debugs its run.

The session stays for a while without a page, and sends its state to one that returns, such as a reloaded one.
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from itertools import count
from typing import Any, Final, NamedTuple

import anyio
from starlette.websockets import WebSocket, WebSocketDisconnect

from seoro.ui.answers import RequestError
from seoro.ui.debug_relay import Adapter
from seoro.ui.debugged_run import DebuggedRun
from seoro.ui.site import Site

RETURN_WITHIN: Final = 60.0  # [s] for a page to return, then the run is cancelled
RUN_EVENT: Final = "seoro/run"
BREAKPOINTS_EVENT: Final = "seoro/breakpoints"
REPLACED: Final = 4409  # close code for a page whose run another page debugs
_FINISHED: Final = 1000  # close code of pages that end the session; reloaded and lost ones have others
_MOST_OUTPUT: Final = 200  # texts that a page shows
_ENDS: Final = ("terminated", "exited")  # events after the end of a run
_MOVES: Final = ("continue", "next", "stepIn", "stepOut", "seoro/step")  # requests that end a pause


class _Request(NamedTuple):
    """A request that the adapter has not answered yet. Pages that return count from 1 again."""

    page: WebSocket
    number: object
    command: str
    arguments: Any


class DebugSession:
    """One session of debugging, with at most one page at a time.

    Args:
        site: The site.
        adapter: The debug adapter.

    Attributes:
        left: Time at which the last page left; infinite while there is one.
    """

    def __init__(self, site: Site, adapter: Adapter) -> None:
        self._adapter = adapter
        self._run = DebuggedRun(site, adapter.stop)
        self._page: WebSocket | None = None
        self._sending = anyio.Lock()  # state first, later messages after it
        self._numbers = count(1)
        self._requests: dict[object, _Request] = {}
        self._breakpoints: dict[str, Mapping[str, Any]] = {}  # by file
        self._output: deque[Mapping[str, Any]] = deque(maxlen=_MOST_OUTPUT)
        self._pause: Mapping[str, Any] | None = None
        self._is_over = False
        self.left = math.inf
        self._scope = anyio.CancelScope(deadline=anyio.current_time() + RETURN_WITHIN)

    @property
    def run_id(self) -> str:
        """Id of the run to which a page can return; empty without one."""
        return "" if self._is_over or self._scope.cancel_called else self._run.id

    async def serve(self) -> None:
        """Relay messages of the adapter until it ends, or no page returns; then the run has ended."""
        try:
            with self._scope:
                while (message := await self._adapter.receive()) is not None:
                    async with self._sending:
                        await self._relay(message)
        finally:
            with anyio.CancelScope(shield=True):
                self._is_over = True
                await self._adapter.end()
                await self._run.end()
                if self._page is not None:
                    await _close(self._page, _FINISHED)

    def end(self) -> None:
        """End the run with its clean-up, and the session."""
        self._scope.cancel()

    async def attach(self, page: WebSocket) -> None:
        """Send the state to a page, and relay its requests until it leaves.

        Args:
            page: Accepted connection of the page. A page that was there before is closed.
        """
        async with self._sending:
            before, self._page = self._page, page
            self.left = self._scope.deadline = math.inf
            if before is not None:
                await _close(before, REPLACED, "another page debugs this run")
            for message in self._state():
                await _send(page, message)
        if self._is_over:
            await _close(page, _FINISHED)
            return
        code = _FINISHED
        try:
            while (message := await page.receive())["type"] != "websocket.disconnect":
                await self._take(page, message.get("text") or "")
            code = message["code"]
        finally:
            if self._page is page:
                self._leave(code)

    def _leave(self, code: int) -> None:
        """Note that the page has left; the session stays if the page may return to an active run."""
        self._page, self.left = None, anyio.current_time()
        if code == _FINISHED or not self.run_id:
            self.end()
        else:
            self._scope.deadline = self.left + RETURN_WITHIN

    def _state(self) -> list[Mapping[str, Any]]:
        """Return the events that lead a page to the present state."""
        if not self._run.is_registered:
            return []
        breakpoints = [_event(BREAKPOINTS_EVENT, found) for found in self._breakpoints.values()]
        pause = [] if self._pause is None else [self._pause]
        return [_event(RUN_EVENT, self._run.data), *breakpoints, *self._output, *pause]

    # -------------------------------------------------------- from the page

    async def _take(self, page: WebSocket, text: str) -> None:
        try:
            await self._adapter.send(await self._read(page, text))
        except RequestError as error:
            await _send(page, error.data)

    async def _read(self, page: WebSocket, text: str) -> Mapping[str, Any]:
        """Return a request of a page with the number that it has for the adapter.

        Raises:
            RequestError: Invalid request, or an invalid launch.
        """
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            message = None
        command = (
            message.get("command") if isinstance(message, dict) and message.get("type") == "request" else None
        )
        if not isinstance(command, str):
            raise RequestError(400, "invalid message", "expected a request of the Debug Adapter Protocol")
        arguments = message.get("arguments")
        if command == "launch":
            arguments = await self._run.prepare(arguments)
        number = next(self._numbers)
        self._requests[number] = _Request(page, message.get("seq"), command, arguments)
        return {**message, "seq": number, "arguments": arguments}

    # -------------------------------------------------------- from the adapter

    async def _relay(self, message: Mapping[str, Any]) -> None:
        """Note the state that a message changes, and send it to the page."""
        page = self._page
        if message.get("type") == "response":
            request = self._requests.pop(message.get("request_seq"), None)
            if request is None:
                return
            message = {**message, "request_seq": request.number}
            if message.get("success"):
                await self._note_answer(request, message)
            if request.page is not page:  # that one has left
                return
        else:
            await self._note_event(message)
        if page is not None:
            await _send(page, message)

    async def _note_answer(self, request: _Request, message: Mapping[str, Any]) -> None:
        if request.command == "launch":
            self._run.register()
            await _send(request.page, _event(RUN_EVENT, self._run.data))
        elif request.command == "setBreakpoints":
            source, wanted = request.arguments["source"], request.arguments.get("breakpoints") or ()
            placed = zip(wanted, message["body"]["breakpoints"], strict=True)
            found = [{**asked, **answered} for asked, answered in placed]
            self._breakpoints[source["path"]] = {"source": source, "breakpoints": found}
        elif request.command in _MOVES:
            self._pause = None

    async def _note_event(self, message: Mapping[str, Any]) -> None:
        name = message.get("event")
        if name == "output":
            self._output.append(message)
        elif name == "stopped":
            self._pause = message
        elif name in _ENDS:
            self._is_over = True
            await self._run.end()
            if self._page is None:
                self.end()


def _event(name: str, body: Mapping[str, Any]) -> Mapping[str, Any]:
    return {"seq": 0, "type": "event", "event": name, "body": body}


async def _send(page: WebSocket, message: Mapping[str, Any]) -> None:
    """Send a message; one to a page that has left is ignored: `attach` notices it."""
    with suppress(WebSocketDisconnect, RuntimeError):
        await page.send_text(json.dumps(message))


async def _close(page: WebSocket, code: int, reason: str = "") -> None:
    """Close the connection of a page, which may have left."""
    with suppress(WebSocketDisconnect, RuntimeError):
        await page.close(code, reason)
