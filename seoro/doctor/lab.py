"""Checks of the paths to a lab: from here and from executors to each endpoint of its nodes."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from seoro.bridges.executor.asking import Executor
from seoro.bridges.executor.probing import PROBE, PROBE_TIMEOUT, EndpointReport, Hop, ProbeRequest
from seoro.bridges.launch import is_installed, is_known, known_simulators
from seoro.bridges.wire.results import Result
from seoro.doctor.endpoint import check_endpoint
from seoro.doctor.findings import Finding, Health, failed, ok, warning
from seoro.doctor.nodes import Viewer, place_findings
from seoro.doctor.peers import RENEW
from seoro.errors import BackendError, BackendRefused
from seoro.lab.probes import probe
from seoro.lab.reading import Lab
from seoro.lab.recorded import recorded_robots
from seoro.lab.status import ListedRobot, listed_robots

HERE: Final = Viewer()
_START: Final = "start the node with `seoro sim` or `seoro bridge`, or correct the endpoint"
_NOT_NEEDED: Final = "runs on executors do not need this path"
_ENDS: Final = {
    Hop.POLICY: "not checked",
    Hop.KEYS: "wrong keys",
    Hop.SESSION: "no session",
}


@dataclass(frozen=True)
class Places:
    """Endpoints to check, and the expected nodes.

    Args:
        endpoints: Zenoh endpoints.
        lab: Lab file, if any.
    """

    endpoints: tuple[str, ...] = ()
    lab: Lab | None = None

    def wanted(self, endpoint: str) -> tuple[ListedRobot, ...]:
        """Return the robots of the lab file at an endpoint."""
        robots = () if self.lab is None else listed_robots(self.lab)
        return tuple(each for each in robots if each.endpoint == endpoint)

    def called(self, endpoint: str) -> str:
        """Return the name of an endpoint in findings, with its nodes in the lab file."""
        here = [name for name, (place, _) in self._nodes.items() if place == endpoint]
        return f"{', '.join(here)} ({endpoint})" if here else endpoint

    @property
    def _nodes(self) -> dict[str, tuple[str | None, str | None]]:
        """Addresses of the bridges and the simulator in the lab file."""
        lab = self.lab
        if lab is None:
            return {}
        names = (*lab.bridges, *(() if lab.simulator is None else (lab.simulator[0],)))
        return {name: lab.address(name) for name in names}

    def names(self, endpoint: str) -> tuple[str, ...]:
        """Return the names of the nodes of the lab file at an endpoint."""
        return tuple(name for place, name in self._nodes.values() if place == endpoint and name is not None)


NOWHERE: Final = Places()


async def check_lab(
    places: Places, folder: Path | None, checked: str = "", *, is_needed: bool = True
) -> AsyncIterator[Finding]:
    """Check the path from here to each endpoint of a lab, and its nodes and robots.

    Args:
        places: The lab.
        folder: Folder of keys.
        checked: Endpoint that was checked already.
        is_needed: Whether runs use these paths; runs on executors use those from there.
    """
    for finding in (*_started(places.lab), *_recorded(places.lab)):
        yield finding
    for endpoint in places.endpoints:
        if endpoint == checked:
            continue
        there = await check_endpoint(endpoint, _START)
        there = Finding(places.called(endpoint), there.health, there.text, there.help)
        if there.health is not Health.FAILED:
            yield there
            seen = await probe(endpoint, folder, places.names(endpoint))
            if seen.ends_at is None or is_needed:
                for finding in endpoint_findings(seen, places, HERE):
                    yield finding
                continue
            [there] = endpoint_findings(seen, places, HERE)
        yield there if is_needed else warning(there.what, there.text, f"{there.help}; {_NOT_NEEDED}")


def endpoint_findings(seen: EndpointReport, places: Places, viewer: Viewer) -> Iterator[Finding]:
    """Yield the findings about an endpoint, hop by hop."""
    if seen.ends_at is not None:
        yield failed(f"{viewer.prefix}{seen.endpoint}", f"{_ENDS[seen.ends_at]}: {seen.why}", seen.advice)
        return
    yield ok(f"{viewer.prefix}{seen.endpoint}", f"Zenoh answers{f', to {seen.who}' if seen.who else ''}")
    yield from place_findings(seen, places.wanted(seen.endpoint), places.names(seen.endpoint), viewer)


def _started(lab: Lab | None) -> Iterator[Finding]:
    """Check the simulator that is started for runs in a lab."""
    if lab is None or lab.simulator is None or lab.simulator[1].simulator is None:
        return
    what, name = lab.simulator[0], lab.simulator[1].simulator
    if not is_known(name):
        yield failed(what, f"unknown simulator '{name}'", f"simulators: {', '.join(known_simulators())}")
    elif not is_installed(name):
        yield failed(what, f"simulator '{name}' is not installed here", f"pip install 'seoro[{name}]'")
    else:
        yield ok(what, f"started for each run, with {name}")


def _recorded(lab: Lab | None) -> Iterator[Finding]:
    """Check the bags of recorded robots."""
    for robot in recorded_robots(lab):
        if robot.problem:
            yield failed(robot.name, robot.problem, robot.advice or "correct its bag in the lab file")
        else:
            yield ok(robot.name, f"recorded in the bag {robot.bag}: {robot.contents}")


async def check_from_executor(executor: Executor, places: Places) -> AsyncIterator[Finding]:
    """Check the path from an executor to a lab, which its runs use."""
    if not places.endpoints:
        return
    try:
        sight = await executor.ask(PROBE, ProbeRequest(endpoints=places.endpoints), PROBE_TIMEOUT)
    except BackendRefused as refused:
        if refused.code == Result.FEATURE_UNSUPPORTED:
            yield warning(executor.name, "cannot check its path to the lab", RENEW)
        else:
            text = f"refused to check its path to the lab: {refused}"
            yield warning(executor.name, text, "use the keys of an operator")
        return
    except BackendError as error:
        text = f"did not report its path to the lab: {error}"
        yield failed(executor.name, text, "try again, or check the executor")
        return
    for seen in sight.places:
        for finding in endpoint_findings(seen, places, Viewer("it", f"{executor.name} sees ")):
            yield finding
