"""Routes of the list of runs, and of the data of one run."""

from __future__ import annotations

from collections.abc import AsyncGenerator

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from seoro.client.runs import RemoteRun
from seoro.ui.answers import RequestError, answer, read_object, text_of
from seoro.ui.site import Site
from seoro.ui.sockets import Data, send_all

_BLOCK = "application/octet-stream"


def routes(site: Site) -> list[BaseRoute]:
    """Return the routes of runs."""

    async def follow_list(socket: WebSocket) -> None:
        await send_all(socket, _changes(site))

    async def follow_run(socket: WebSocket) -> None:
        await send_all(socket, _frames(site, socket.path_params["run"]), on_request=True)

    async def read_block(request: Request) -> Response:
        async with site.feeds.viewing(request.path_params["run"]) as feed:
            return Response(await feed.block(request.path_params["number"]), media_type=_BLOCK)

    async def stop(request: Request) -> Response:
        known = site.runs.get(request.path_params["run"])
        reason = text_of(await read_object(request, "reason"), "reason")
        if not isinstance(known.source, RemoteRun):
            raise RequestError(
                409, "this run was started elsewhere", "stop it where it was started, for example with Ctrl-C"
            )
        await known.source.stop(reason)
        return answer({})

    return [
        WebSocketRoute("/api/runs", follow_list),
        WebSocketRoute("/api/run/{run}", follow_run),
        Route("/api/run/{run}/block/{number:int}", read_block),
        Route("/api/run/{run}/stop", stop, methods=["POST"]),
    ]


async def _changes(site: Site) -> AsyncGenerator[Data, None]:
    async for changes in site.runs.changes():
        yield changes.data


async def _frames(site: Site, run: str) -> AsyncGenerator[Data, None]:
    async with site.feeds.viewing(run) as feed:
        async for piece in feed.frames():
            yield piece
        raise RequestError(503, feed.problem)
