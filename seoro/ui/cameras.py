"""Routes of the cameras of a run's simulator: their names, and live pictures."""

from __future__ import annotations

import string
import time
from collections.abc import AsyncGenerator, Sequence
from pathlib import Path
from typing import Final

import anyio
import anyio.to_thread
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from seoro.files.executor_links import LINKS
from seoro.ui.answers import answer
from seoro.ui.pictures import NoPictures, connect_pictures
from seoro.ui.registry import Known, LocalSource
from seoro.ui.site import Site
from seoro.ui.sockets import Data, send_all

PERIOD: Final = 0.2  # [s] between two pictures for a viewer
_HEX: Final = frozenset(string.hexdigits)
_HOME: Final = "*/runs/{run}/home"  # folder of the programs of a run, in the folder of an executor


def routes(site: Site) -> list[BaseRoute]:
    """Return the routes of cameras."""

    async def list_cameras(request: Request) -> Response:
        known = site.runs.get(request.path_params["run"])
        try:
            async with connect_pictures(await _folders(known, site)) as pictures:
                names = await pictures.cameras()
        except NoPictures as error:
            return answer({"cameras": [], "problem": str(error)})
        return answer({"cameras": [{"name": name} for name in names], "problem": ""})

    async def follow(socket: WebSocket) -> None:
        await send_all(socket, _pictures(site, socket.path_params["run"], socket.query_params.get("name", "")))

    return [
        Route("/api/run/{run}/cameras", list_cameras),
        WebSocketRoute("/api/run/{run}/camera", follow),
    ]


async def _pictures(site: Site, run: str, camera: str) -> AsyncGenerator[Data, None]:
    """Yield pictures until the run ends; the next one is taken when the page has received the one before."""
    async with connect_pictures(await _folders(site.runs.get(run), site)) as pictures:
        while True:
            began = time.monotonic()
            yield (await pictures.take(camera)).png
            await anyio.sleep(PERIOD - (time.monotonic() - began))


async def _folders(known: Known, site: Site) -> Sequence[Path]:
    """Return the folders of a run that may have its socket.

    Raises:
        NoPictures: The run has ended, or is on another machine.
    """
    if known.run.status.is_final:
        raise NoPictures("the run has ended")
    if isinstance(known.source, LocalSource):
        return [known.source.trace.parent]
    found = await anyio.to_thread.run_sync(_executor_folders, site.state, known.source.id)
    if not found:
        raise NoPictures(
            "pictures are shown for runs on this machine only; "
            f"the executor '{known.run.place}' is on another one, or that of another user"
        )
    return found


def _executor_folders(state: Path, run: str) -> Sequence[Path]:
    """Return the folders of a run on an executor of this user, or of a site."""
    if not run or not _HEX.issuperset(run):  # as an executor reports it
        return []
    return [
        found
        for place in (state, state.parent, state.parent / LINKS)
        for found in place.glob(_HOME.format(run=run))
    ]
