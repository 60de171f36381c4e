"""Routes of campaigns: their list, their results, and their reports."""

from __future__ import annotations

from collections.abc import AsyncGenerator

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from seoro.ui.answers import answer
from seoro.ui.campaign_feeds import CampaignFeeds
from seoro.ui.site import Site
from seoro.ui.sockets import Data, send_all


def routes(site: Site) -> list[BaseRoute]:
    """Return the routes of campaigns."""
    feeds = CampaignFeeds(site.folders, site.runs)

    async def list_all(_: Request) -> Response:
        return answer({"campaigns": await feeds.listed()})

    async def follow(socket: WebSocket) -> None:
        await send_all(socket, _snapshots(feeds, socket.path_params["campaign"]))

    async def report(request: Request) -> Response:
        feed = await feeds.feed(request.path_params["campaign"])
        headers = {"content-disposition": 'attachment; filename="report.html"'}
        return Response(await feed.report(), media_type="text/html", headers=headers)

    return [
        Route("/api/campaigns", list_all),
        WebSocketRoute("/api/campaign/{campaign}", follow),
        Route("/api/campaign/{campaign}/report", report),
    ]


async def _snapshots(feeds: CampaignFeeds, campaign: str) -> AsyncGenerator[Data, None]:
    feed = await feeds.feed(campaign)
    async for snapshot in feed.snapshots():
        yield {**snapshot, "id": campaign}
