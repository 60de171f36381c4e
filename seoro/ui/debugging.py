"""Route of the debugger: a page is the client of a debug adapter, `seoro dap`, which the site runs for it.

A page launches a file of the list of scenarios. The site adds the folder for the trace, and reports the run by the
event `seoro/run` before it answers. A page that is loaded again names this run to return to its session.
"""

from __future__ import annotations

import json
import math
from typing import Final

import anyio
from anyio.abc import TaskStatus
from starlette.routing import BaseRoute, WebSocketRoute
from starlette.websockets import WebSocket

from seoro.ui.answers import RequestError
from seoro.ui.debug_relay import start_adapter
from seoro.ui.debug_session import DebugSession
from seoro.ui.site import Site

MOST_SESSIONS: Final = 4  # at a time


def routes(site: Site) -> list[BaseRoute]:
    """Return the route of the debugger."""
    sessions = _Sessions(site)

    async def debug(socket: WebSocket) -> None:
        await socket.accept()
        run = socket.query_params.get("run")
        try:
            site.rights.check_owner()
            session = await sessions.start() if run is None else sessions.find(run)
        except RequestError as error:
            await socket.send_text(json.dumps(error.data))
            await socket.close()
            return
        await session.attach(socket)

    return [WebSocketRoute("/api/debug", debug)]


class _Sessions:
    """The sessions of a site. They last as long as their runs, not as the sockets of their pages.

    Args:
        site: The site.
    """

    def __init__(self, site: Site) -> None:
        self._site = site
        self._room = anyio.Semaphore(MOST_SESSIONS)
        self._open: dict[DebugSession, anyio.Event] = {}  # set when it has ended

    def find(self, run: str) -> DebugSession:
        """Return the session of an active run.

        Raises:
            RequestError: No session has this run.
        """
        for session in self._open:
            if run and session.run_id == run:
                return session
        raise RequestError(404, "the debugged run has ended", "start it again")

    async def start(self) -> DebugSession:
        """Start a session; if all places are taken, the one whose page left first ends.

        Raises:
            RequestError: All places are taken by pages.
        """
        await self._acquire()
        session: DebugSession = await self._site.tasks.start(self._serve)
        return session

    async def _acquire(self) -> None:
        while True:
            try:
                self._room.acquire_nowait()
                return
            except anyio.WouldBlock:
                oldest = min(self._open, key=lambda session: session.left, default=None)
            if oldest is None or math.isinf(oldest.left):
                raise RequestError(503, "too many debugged runs", f"end one of the {MOST_SESSIONS} first")
            oldest.end()
            await self._open[oldest].wait()

    async def _serve(self, *, task_status: TaskStatus[DebugSession]) -> None:
        ended = anyio.Event()
        try:
            async with start_adapter() as adapter:
                session = DebugSession(self._site, adapter)
                self._open[session] = ended
                task_status.started(session)
                try:
                    await session.serve()
                finally:
                    del self._open[session]
        finally:
            self._room.release()
            ended.set()
