"""Findings about simulators and bridges, and about their robots."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from seoro.bridges.executor.clocks import Clock
from seoro.bridges.executor.probing import EndpointReport, NodeReport
from seoro.bridges.leasing.emergency_stop import describe_stop
from seoro.bridges.serving.node import KIND
from seoro.bridges.wire.keys import MAJOR
from seoro.bridges.wire.lab import LabState, RobotCheck, RobotState
from seoro.doctor.findings import Finding, failed, ok, warning
from seoro.doctor.peers import RELEASE, clock_finding, latency_finding, version_finding
from seoro.lab.readiness import unmet_conditions
from seoro.lab.schema import BeforeFile
from seoro.lab.status import ListedRobot

LONG_AGO: Final = 5.0  # [s] since the last message of a robot; they publish many times a second
NOW: Final = 0.5  # [s], longest age that is shown as "now"
LOW: Final = 0.15  # charge of a battery
_HOP: Final = (
    "check that the robot is on and its ROS 2 system runs, and endpoint (`--ros`), domain and namespace of the "
    "bridge; `seoro ros topic list` lists topics"
)
STANDS_STILL: Final = "if it hangs (`kill -STOP`, a debugger), restart it; if it has just ended, try again"


@dataclass(frozen=True)
class Viewer:
    """Observer of a finding, in the words of messages: `we` with an empty prefix, or `it` with `lab-a sees `."""

    whom: str = "we"
    prefix: str = ""


def place_findings(
    seen: EndpointReport, wanted: Sequence[ListedRobot], names: Sequence[str], viewer: Viewer
) -> Iterator[Finding]:
    """Yield the findings about a reached endpoint.

    Args:
        seen: Observations.
        wanted: Robots of the lab file there.
        names: Names of the nodes of the lab file there.
        viewer: Observer.
    """
    there = [node.node for node in seen.nodes]
    for node in seen.nodes:
        here = [each for each in wanted if each.node in (None, node.node)]
        yield from node_findings(node, seen, here, viewer)
    for name in names:
        if name not in there:
            yield _missing(f"{viewer.prefix}{name}", seen.endpoint, there, seen.who)
    if not there and not names:
        yield _missing(f"{viewer.prefix}{seen.endpoint}", seen.endpoint, there, seen.who)
    if len(there) > 1 and any(each.node is None for each in wanted):
        text = f"the lab file is ambiguous: several nodes are at {seen.endpoint}"
        yield failed(f"{viewer.prefix}{seen.endpoint}", text, f"add a `name` to the lab file: {', '.join(there)}")


def _missing(what: str, endpoint: str, there: Sequence[str], who: str) -> Finding:
    known = f"nodes there: {', '.join(there)}" if there else "no simulator or bridge there"
    advice = "start it with `seoro sim` or `seoro bridge`, or correct the lab file"
    if who and not there:
        advice += f"; revoked keys see no nodes, either: ask an admin of the lab about {who}"
    return failed(what, f"not found at {endpoint}: {known}", advice)


def node_findings(
    node: NodeReport, place: EndpointReport, wanted: Sequence[ListedRobot], viewer: Viewer
) -> Iterator[Finding]:
    """Yield the findings about a node and its robots."""
    what = f"{viewer.prefix}{node.node}"
    if node.major != str(MAJOR):
        text = f"has protocol {node.major}, but this seoro has protocol {MAJOR}"
        yield failed(what, text, "use the same version of seoro on both sides")
        return
    if node.count > 1:
        text = f"duplicate name of {node.count} nodes at {place.endpoint}: any of them may answer"
        yield failed(what, text, "give each its own name with `--node` or `--name`")
    if node.why:
        yield failed(what, node.why, STANDS_STILL)
    state = node.state
    if state is None:
        return
    yield version_finding(what, f"{_kind(state)}, ", (state.version, node.major), str(MAJOR))
    yield _rights_finding(what, node, place.who, viewer)
    if not node.why:
        clock = None if node.offset is None else Clock(node.offset, 2.0 * node.doubt)
        yield clock_finding(what, clock)
        yield latency_finding(what, node.half, node.most, node.exchanges)
    if state.stopped is not None:
        yield failed(what, f"emergency stop by {describe_stop(state.stopped)}", RELEASE)
    yield from _robots_findings(what, state, wanted, node.checks)


def _kind(state: LabState) -> str:
    if state.kind == KIND:
        return "bridge to robots"
    time = "" if state.clock == "real" else ", time advanced by runs"
    return f"simulator ({state.kind}){time}"


def _rights_finding(what: str, node: NodeReport, who: str, viewer: Viewer) -> Finding:
    whom = f"{viewer.whom} ({who})" if who else viewer.whom
    if node.is_usable is None:
        return ok(what, f"{whom} can query it; only operators can use robots")
    if not node.is_usable:
        advice = "allow the role in the configuration of the router between; see docs/how-to/keys.md"
        return failed(what, f"{whom} can query it, but not use its robots: {node.why_not}", advice)
    return ok(what, f"{whom} can query it and use its robots")


def _robots_findings(
    what: str, state: LabState, wanted: Sequence[ListedRobot], checks: Mapping[str, RobotCheck]
) -> Iterator[Finding]:
    called = {each.remote_name: each for each in wanted}
    if not state.robots and not called:
        yield ok(what, "no robots")
    for robot in state.robots:
        known = called.pop(robot.name, None)
        named = f"{what}/{robot.name}"
        if known is None:
            yield from robot_findings(named, state, robot, None, checks.get(robot.name))
        else:
            shown = named if known.name == robot.name else f"{named} ({known.name})"
            yield from robot_findings(shown, state, robot, known.before, checks.get(robot.name))
    there = ", ".join(robot.name for robot in state.robots)
    for name, each in called.items():
        advice = f"robots there: {there}" if there else "no robots there: the world of a simulator has its robots"
        yield failed(f"{what}/{name}", f"robot '{each.name}' of the lab file not found", advice)


def robot_findings(
    what: str, lab: LabState, robot: RobotState, before: BeforeFile | None, check: RobotCheck | None = None
) -> Iterator[Finding]:
    """Yield the findings about a robot: its messages, users and problems.

    Args:
        what: Name of the robot in findings.
        lab: State of its node.
        robot: State of the robot.
        before: Required state before a run; None without a lab file.
        check: Check by its bridge, if any; otherwise topics without messages are reported.
    """
    silent = _silence(robot) if check is None else ""
    yield from _state_findings(what, lab, robot, before, silent)
    for problem in () if check is None else check.problems:
        yield (failed if problem.is_fatal else warning)(what, problem.text, problem.help)


def _state_findings(
    what: str, lab: LabState, robot: RobotState, before: BeforeFile | None, silent: str
) -> Iterator[Finding]:
    """Yield the findings about the state of a robot, with its silent topics as text."""
    if robot.seen is None and lab.kind == KIND:
        yield failed(what, f"no messages received{silent}", _HOP)
        return
    if robot.seen is not None and robot.seen > LONG_AGO:
        yield failed(what, f"last message {robot.seen:.0f} s ago{silent}", _HOP)
        return
    yield ok(what, ", ".join(_parts(lab, robot)))
    if robot.stopped is not None:
        advice = f"make sure that it is safe, then `seoro lab release --estop {robot.name} --reason ...`"
        yield failed(what, f"emergency stop by {describe_stop(robot.stopped)}", advice)
    asked = before or BeforeFile()
    if robot.battery is not None and robot.battery < LOW and asked.battery is None:
        yield warning(what, f"battery at {robot.battery:.0%}", "charge it")
    if silent:
        advice = "check the publishers of these topics, and the profile of the robot"
        yield warning(what, f"topics without messages{silent}", advice)
    if found := unmet_conditions(asked, robot):
        advice = "required by `before` in the lab file: charge it, drive it there, or set its pose"
        yield warning(what, f"not ready for runs: {'; '.join(found)}", advice)


def _parts(lab: LabState, robot: RobotState) -> Iterator[str]:
    """Yield parts of the description of a robot."""
    if robot.seen is not None:
        yield "seen now" if robot.seen < NOW else f"seen {robot.seen:.1f} s ago"
    if robot.holder:
        yield f"held by {robot.holder}"
    elif robot.lease is not None:
        until = time.strftime("%d %b %H:%M", time.localtime(robot.lease.until))
        yield f"leased until {until} ({robot.lease.purpose or robot.lease.lease})"
    elif lab.holder:
        yield f"held by {lab.holder}, with all robots of the node"
    else:
        yield "free"
    if robot.waiting:
        yield f"{len(robot.waiting)} waiting"
    if robot.localised is not None:
        known = "localised" if robot.localised else "not localised yet"
        yield (
            known if robot.deviation is None or not robot.localised else f"{known} within {robot.deviation:.2f} m"
        )
    if robot.battery is not None:
        yield f"battery at {robot.battery:.0%}"


def _silence(robot: RobotState) -> str:
    """List the topics without messages, with reasons."""
    found = [f"{each.topic} ({each.why})" for each in robot.topics if each.why]
    return f": {', '.join(found)}" if found else ""
