"""Routes of the lab: its state, leases, stops, and the emergency stop."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Iterable, Mapping, Sequence
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from seoro.client.lab import LabControl
from seoro.lab.outcomes import Outcome
from seoro.lab.recorded import recorded_robots
from seoro.lab.status import listed_robots
from seoro.ui.answers import RequestError, answer, read_object, text_of
from seoro.ui.lab_stop import EmergencyStop, outcome_data
from seoro.ui.lab_watch import LabWatch
from seoro.ui.site import Site
from seoro.ui.sockets import Data, send_all

LOCAL: Final = ("tcp/127.0.0.1:7450", "tcp/127.0.0.1:7460", "tcp/127.0.0.1:7470")
"""Endpoints of this machine, which are the lab if no lab file is named; they need not be in use."""
DURATION: Final = 600.0  # [s] of a lease
LONGEST: Final = 7 * 86_400.0  # [s] of a lease


def routes(site: Site) -> list[BaseRoute]:
    """Return the routes of the lab."""
    file = site.lab
    listed = () if file is None else tuple(listed_robots(file))

    def endpoints() -> Sequence[str]:
        return (*(() if file is None else file.endpoints), *site.places.endpoints)

    watch = LabWatch(endpoints, LOCAL if file is None else (), listed, site.keys, recorded_robots(file))
    site.start_soon(watch.serve)

    def control() -> LabControl:
        return LabControl(watch.endpoints, file, site.keys)

    def answer_outcomes(outcomes: Iterable[Outcome]) -> Response:
        watch.read_again()
        shown = [each for each in outcomes if each.is_reached or each.endpoint not in watch.optional]
        return answer({"outcomes": [outcome_data(each) for each in shown]})

    async def follow(socket: WebSocket) -> None:
        await send_all(socket, _snapshots(watch))

    async def stop_all(request: Request) -> Response:
        reason = text_of(await read_object(request, "reason"), "reason")
        stop = EmergencyStop(control(), watch, site.tasks, site.own_runs)
        return answer({"outcomes": await stop.stop_all(reason)})

    async def release(request: Request) -> Response:
        data = await read_object(request, "reason", "robots")
        reason, robots = text_of(data, "reason"), _robots_in(data)
        if robots:
            return answer_outcomes(await control().release_estop(*robots, reason=reason))
        return answer_outcomes(await control().release_all(reason))

    async def stop(request: Request) -> Response:
        return answer_outcomes(await control().stop(*_robots_in(await read_object(request, "robots"))))

    async def lease(request: Request) -> Response:
        data = await read_object(request, "robots", "seconds", "purpose")
        robots, duration, purpose = _robots_in(data), _duration_in(data), text_of(data, "purpose")
        found = await control().lease(*robots, duration=duration, purpose=purpose)
        watch.read_again()
        outcomes = [{"name": robot, "error": "", "done": "leased"} for robot in found.robots]
        return answer({"outcomes": outcomes, "lease": found.name, "until": found.until})

    async def end_lease(request: Request) -> Response:
        lease = text_of(await read_object(request, "lease"), "lease")
        return answer_outcomes([await control().release(lease)])

    posts = {"stop-all": stop_all, "release": release, "stop": stop, "lease": lease, "end-lease": end_lease}
    return [
        WebSocketRoute("/api/lab", follow),
        *(Route(f"/api/lab/{name}", handler, methods=["POST"]) for name, handler in posts.items()),
    ]


async def _snapshots(watch: LabWatch) -> AsyncGenerator[Data, None]:
    async with watch.followed():
        async for snapshot in watch.snapshots():
            yield snapshot


def _robots_in(data: Mapping[str, Any]) -> Sequence[str]:
    robots = data.get("robots", [])
    if not isinstance(robots, list) or not all(isinstance(each, str) for each in robots):
        raise RequestError(400, "invalid `robots`: expected a list of names", field="robots")
    return robots


def _duration_in(data: Mapping[str, Any]) -> float:
    found = data.get("seconds", DURATION)
    if isinstance(found, bool) or not isinstance(found, int | float) or not 0.0 < found <= LONGEST:
        expected = f"expected a number above 0, at most {LONGEST:.0f}"
        raise RequestError(400, "invalid `seconds` of the lease", expected, field="seconds")
    return float(found)
