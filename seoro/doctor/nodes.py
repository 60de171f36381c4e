"""Simulators and bridges, as somebody sees them, in words; their robots are in `robots.py`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from seoro.bridges.executor.clocks import Clock
from seoro.bridges.executor.sight import NodeSeen, PlaceSeen
from seoro.bridges.leasing.latch import in_words
from seoro.bridges.serving.node import CALLED
from seoro.bridges.wire.keys import MAJOR
from seoro.bridges.wire.lab import LabState
from seoro.doctor.findings import Finding, failed, ok
from seoro.doctor.measured import RELEASE, tell_clock, tell_latency, tell_version
from seoro.doctor.robots import tell_robot
from seoro.lab.schema import BeforeFile
from seoro.lab.seeing import Known

STANDS_STILL: Final = (
    "if it stands still (`kill -STOP`, a debugger), end it and start it again; if it has just ended, look again"
)


@dataclass(frozen=True)
class Wanted:
    """A robot of a lab file, and what it has to be like before a run."""

    known: Known
    before: BeforeFile


@dataclass(frozen=True)
class Viewer:
    """Who has looked, in the words of messages: `us` and nothing before names, or `it` and `lab-a sees `."""

    whom: str = "us"
    prefix: str = ""


def tell_place(
    seen: PlaceSeen, wanted: Sequence[Wanted], names: Sequence[str], viewer: Viewer
) -> Iterator[Finding]:
    """What was seen at an endpoint that was reached.

    Args:
        seen: What was seen.
        wanted: The robots that a lab file has there.
        names: Of nodes that it has there.
        viewer: Who has looked.
    """
    there = [node.node for node in seen.nodes]
    for node in seen.nodes:
        here = [each for each in wanted if each.known.node in (None, node.node)]
        yield from tell_node(node, seen, here, viewer)
    for name in names:
        if name not in there:
            yield _missing(f"{viewer.prefix}{name}", seen.endpoint, there, seen.who)
    if not there and not names:
        yield _missing(f"{viewer.prefix}{seen.endpoint}", seen.endpoint, there, seen.who)
    if len(there) > 1 and any(each.known.node is None for each in wanted):
        text = f"several nodes are at {seen.endpoint}, and the lab file does not say which it means"
        yield failed(f"{viewer.prefix}{seen.endpoint}", text, f"give it a `name`: {', '.join(there)}")


def _missing(what: str, endpoint: str, there: Sequence[str], who: str) -> Finding:
    known = f"there are {', '.join(there)}" if there else "no simulator or bridge is seen there"
    advice = "start it with `seoro sim` or `seoro bridge`, or correct the lab file"
    if who and not there:
        advice += f"; whose keys are revoked sees nobody: ask who has the key of the lab about {who}"
    return failed(what, f"is not there at {endpoint}: {known}", advice)


def tell_node(node: NodeSeen, place: PlaceSeen, wanted: Sequence[Wanted], viewer: Viewer) -> Iterator[Finding]:
    """A node, as it was seen, and its robots."""
    what = f"{viewer.prefix}{node.node}"
    if node.major != str(MAJOR):
        text = f"speaks version {node.major} of the protocol, and this seoro version {MAJOR}"
        yield failed(what, text, "use the same version of seoro on both sides")
        return
    if node.count > 1:
        text = f"{node.count} nodes at {place.endpoint} have this name: either may be the one that answers"
        yield failed(what, text, "give each a name of its own, with `--node` or `--name`")
    if node.why:
        yield failed(what, node.why, STANDS_STILL)
    state = node.state
    if state is None:
        return
    yield tell_version(what, f"{_kind(state)} ", (state.version, node.major), str(MAJOR))
    yield _tell_rights(what, node, place.who, viewer)
    if not node.why:
        clock = None if node.offset is None else Clock(node.offset, 2.0 * node.doubt)
        yield tell_clock(what, clock)
        yield tell_latency(what, node.half, node.most, node.exchanges)
    if state.stopped is not None:
        yield failed(what, f"nothing moves there: emergency stop by {in_words(state.stopped)}", RELEASE)
    yield from _tell_robots(what, state, wanted)


def _kind(state: LabState) -> str:
    if state.kind == CALLED:
        return "a bridge to robots"
    time = "" if state.clock == "real" else ", whose time runs grant,"
    return f"a simulator ({state.kind}){time}"


def _tell_rights(what: str, node: NodeSeen, who: str, viewer: Viewer) -> Finding:
    whom = f"{viewer.whom}, {who}," if who else viewer.whom
    if node.is_usable is None:
        return ok(what, f"lets {whom} look; using robots is for operators")
    if not node.is_usable:
        advice = "whoever runs the router between has to let roles pass what they may; see docs/security.md"
        return failed(what, f"lets {whom} look, but not use its robots: {node.why_not}", advice)
    return ok(what, f"lets {whom} look and use its robots")


def _tell_robots(what: str, state: LabState, wanted: Sequence[Wanted]) -> Iterator[Finding]:
    called = {each.known.called: each for each in wanted}
    if not state.robots and not called:
        yield ok(what, "has no robots")
    for robot in state.robots:
        known = called.pop(robot.name, None)
        named = f"{what}/{robot.name}"
        if known is None:
            yield from tell_robot(named, state, robot, None)
        else:
            shown = named if known.known.name == robot.name else f"{named} ({known.known.name})"
            yield from tell_robot(shown, state, robot, known.before)
    there = ", ".join(robot.name for robot in state.robots)
    for name, each in called.items():
        advice = f"there are {there}" if there else "there are none: a simulator has those of its world"
        yield failed(f"{what}/{name}", f"robot '{each.known.name}' of the lab file is not there", advice)
