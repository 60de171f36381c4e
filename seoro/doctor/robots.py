"""Findings about robots, from the state that their node reports."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Final

from seoro.bridges.leasing.emergency_stop import describe_stop
from seoro.bridges.serving.node import KIND
from seoro.bridges.wire.lab import LabState, RobotState
from seoro.doctor.findings import Finding, failed, ok, warning
from seoro.lab.readiness import unmet_conditions
from seoro.lab.schema import BeforeFile

LONG_AGO: Final = 5.0  # [s] since the last message of a robot; they publish many times a second
NOW: Final = 0.5  # [s], longest age that is shown as "now"
LOW: Final = 0.15  # charge of a battery
_HOP: Final = (
    "check that the robot is on and its ROS 2 system runs, and endpoint (`--ros`), domain and namespace of the "
    "bridge; `seoro ros topic list` lists topics"
)


def robot_findings(what: str, lab: LabState, robot: RobotState, before: BeforeFile | None) -> Iterator[Finding]:
    """Yield the findings about a robot: its messages, users and problems.

    Args:
        what: Name of the robot in findings.
        lab: State of its node.
        robot: State of the robot.
        before: Required state before a run; None without a lab file.
    """
    silent = _silence(robot)
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
