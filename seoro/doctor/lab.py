"""The ways to a lab: from here to each endpoint at which its nodes are, and from executors to the same."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from seoro.bridges.executor.asking import Executor
from seoro.bridges.executor.sight import LOOK, LOOKED_WITHIN, Hop, Look, PlaceSeen
from seoro.bridges.launch import is_installed, known_simulators
from seoro.bridges.wire.results import Result
from seoro.doctor.endpoint import look_at_endpoint
from seoro.doctor.findings import Finding, Health, failed, ok, warning
from seoro.doctor.measured import RENEW
from seoro.doctor.nodes import Viewer, Wanted, tell_place
from seoro.errors import BackendError, BackendRefused
from seoro.lab.examining import examine
from seoro.lab.reading import Lab
from seoro.lab.seeing import known_of

HERE: Final = Viewer()
_START: Final = "start what should be there with `seoro sim` or `seoro bridge`, or correct the endpoint"
_NOT_NEEDED: Final = "runs on executors need what these see only"
_ENDS: Final = {
    Hop.POLICY: "it is not looked at",
    Hop.KEYS: "the keys are wrong",
    Hop.SESSION: "there is no session",
}


@dataclass(frozen=True)
class Places:
    """Where to look, and what there should be.

    Args:
        endpoints: Where.
        lab: The lab file, if there is one.
    """

    endpoints: tuple[str, ...] = ()
    lab: Lab | None = None

    def wanted(self, endpoint: str) -> tuple[Wanted, ...]:
        """The robots that the lab file has at an endpoint."""
        if self.lab is None:
            return ()
        robots = self.lab.robots
        return tuple(
            Wanted(each, robots[each.name].before) for each in known_of(self.lab) if each.endpoint == endpoint
        )

    def called(self, endpoint: str) -> str:
        """What lines call an endpoint: by what the lab file has there, if it has something."""
        if self.lab is None or endpoint not in self.lab.endpoints:
            return endpoint
        here = [name for name in self._nodes if self.lab.address(name)[0] == endpoint]
        return f"{', '.join(here)} ({endpoint})"

    @property
    def _nodes(self) -> tuple[str, ...]:
        """What the lab file calls its bridges and its simulator."""
        if self.lab is None:
            return ()
        return (*self.lab.bridges, *([] if self.lab.simulator is None else [self.lab.simulator[0]]))

    def names(self, endpoint: str) -> tuple[str, ...]:
        """Names of the nodes that it has there."""
        if self.lab is None:
            return ()
        found = [self.lab.address(node) for node in self._nodes]
        return tuple(name for place, name in found if place == endpoint and name is not None)


NOWHERE: Final = Places()


async def look_at_lab(
    places: Places, folder: Path | None, told: str = "", *, is_needed: bool = True
) -> AsyncIterator[Finding]:
    """Go from here to each endpoint of a lab, and on to its nodes and robots.

    Args:
        places: The lab.
        folder: Of keys, as for commands.
        told: An endpoint that was looked at already.
        is_needed: Whether runs go that way; those on executors go from there.
    """
    for finding in _started(places.lab):
        yield finding
    for endpoint in places.endpoints:
        if endpoint == told:
            continue
        there = await look_at_endpoint(endpoint, _START)
        there = Finding(places.called(endpoint), there.health, there.text, there.help)
        if there.health is not Health.FAILED:
            yield there
            seen = await examine(endpoint, folder, places.names(endpoint))
            if seen.ends_at is None or is_needed:
                for finding in tell_seen(seen, places, HERE):
                    yield finding
                continue
            [there] = tell_seen(seen, places, HERE)
        yield there if is_needed else warning(there.what, there.text, f"{there.help}; {_NOT_NEEDED}")


def tell_seen(seen: PlaceSeen, places: Places, viewer: Viewer) -> Iterator[Finding]:
    """What was seen at an endpoint, hop by hop."""
    if seen.ends_at is not None:
        yield failed(f"{viewer.prefix}{seen.endpoint}", f"{_ENDS[seen.ends_at]}: {seen.why}", seen.advice)
        return
    yield ok(f"{viewer.prefix}{seen.endpoint}", f"Zenoh answers{f', to {seen.who}' if seen.who else ''}")
    yield from tell_place(seen, places.wanted(seen.endpoint), places.names(seen.endpoint), viewer)


def _started(lab: Lab | None) -> Iterator[Finding]:
    """The simulator of a lab that runs start."""
    if lab is None or lab.simulator is None or lab.simulator[1].simulator is None:
        return
    what, name = lab.simulator[0], lab.simulator[1].simulator
    if name not in known_simulators():
        yield failed(what, f"there is no simulator '{name}' here", f"there are {', '.join(known_simulators())}")
    elif not is_installed(name):
        yield failed(what, f"the simulator '{name}' is not installed here", f"pip install 'seoro[{name}]'")
    else:
        yield ok(what, f"is started for each run, with {name}")


async def look_from(executor: Executor, places: Places) -> AsyncIterator[Finding]:
    """What an executor sees of a lab, of which runs there are made."""
    if not places.endpoints:
        return
    try:
        sight = await executor.ask(LOOK, Look(endpoints=places.endpoints), LOOKED_WITHIN)
    except BackendRefused as refused:
        if refused.code == Result.FEATURE_UNSUPPORTED:
            yield warning(executor.name, "cannot say what it sees of the lab", RENEW)
        else:
            text = f"does not say what it sees of the lab: {refused}"
            yield warning(executor.name, text, "look with the keys of an operator")
        return
    except BackendError as error:
        text = f"has not said what it sees of the lab: {error}"
        yield failed(executor.name, text, "look again, or see how the executor does")
        return
    for seen in sight.places:
        for finding in tell_seen(seen, places, Viewer("it", f"{executor.name} sees ")):
            yield finding
