"""Routes of scenarios: the list, and the form of one."""

from __future__ import annotations

import anyio.to_thread
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from seoro.errors import InvalidScenario, UsageError
from seoro.ui.answers import answer
from seoro.ui.parameters import Form, read_form
from seoro.ui.site import Site


def routes(site: Site) -> list[BaseRoute]:
    """Return the routes of scenarios."""

    async def list_all(_: Request) -> Response:
        return answer({"scenarios": await anyio.to_thread.run_sync(site.scenarios.list)})

    async def describe(request: Request) -> Response:
        file, name = (request.query_params.get(each, "") for each in ("file", "name"))
        return answer(await anyio.to_thread.run_sync(_form, site, file, name))

    return [Route("/api/scenarios", list_all), Route("/api/scenario", describe)]


def _form(site: Site, file: str, name: str) -> dict[str, object]:
    path = site.scenarios.path(file)
    try:
        return read_form(path, file, name).data
    except (InvalidScenario, UsageError) as error:
        return {**Form().data, "problem": str(error)}
