"""The application: the page, its files, and the routes of all areas."""

from __future__ import annotations

from importlib.resources import files
from importlib.util import find_spec
from typing import Final

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from starlette.routing import BaseRoute, Route
from starlette.types import ASGIApp

from seoro import __version__
from seoro.errors import SeoroError
from seoro.ui import (
    cameras,
    campaigns,
    comparing,
    debugging,
    lab,
    result_routes,
    run_routes,
    scenario_routes,
    starting,
)
from seoro.ui.answers import RequestError, answer, answer_error
from seoro.ui.rights import OnlyReading
from seoro.ui.security import Access, Guard
from seoro.ui.site import Site

AREAS: Final = (
    run_routes,
    result_routes,
    scenario_routes,
    starting,
    lab,
    campaigns,
    comparing,
    cameras,
    debugging,
)
_PATHS: Final = ("/", "/runs", "/run/{id}", "/start", "/lab", "/campaigns", "/campaign/{id}", "/compare")
_FILES: Final = {  # packages and media types of built files
    "ui.js": ("seoro.ui", "text/javascript"),
    "ui.css": ("seoro.ui", "text/css"),
    "world3d.js": ("seoro.report", "text/javascript"),
}
_SIMULATORS: Final = ("mujoco", "pybullet")
_PAGE: Final = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width,initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>seoro</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/static/ui.css">
<script type="module" src="/static/ui.js"></script>
</head><body><div id="app"></div><noscript>These pages need JavaScript.</noscript></body></html>
"""


def make_application(site: Site, access: Access) -> ASGIApp:
    """Make the application of a site, which admits only requests with its secrets."""

    async def describe(_: Request) -> Response:
        return answer(
            {
                "version": __version__,
                "places": site.places.data,
                "simulators": [name for name in _SIMULATORS if find_spec(name) is not None],
                "hasLab": site.places.has_client,
                "mayStart": site.places.has_executor and site.rights.may_act,
                "mayAct": site.rights.may_act,
                "mayDebug": site.rights.is_owner,
                "demo": site.is_demo,
            }
        )

    routes: list[BaseRoute] = [Route(path, _page) for path in _PATHS]
    routes += [Route("/static/{name}", _static), Route("/api/site", describe)]
    for area in AREAS:
        routes += area.routes(site)
    handlers = dict.fromkeys((HTTPException, RequestError, SeoroError, OSError, Exception), answer_error)
    application: ASGIApp = Starlette(routes=routes, exception_handlers=handlers)
    return Guard(application if site.rights.may_act else OnlyReading(application), access)


async def _page(_: Request) -> Response:
    return HTMLResponse(_PAGE)


async def _static(request: Request) -> Response:
    name = request.path_params["name"]
    if name not in _FILES:
        raise RequestError(404, "unknown file")
    package, media_type = _FILES[name]
    return Response((files(package) / "static" / name).read_bytes(), media_type=media_type)
