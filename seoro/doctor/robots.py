"""Robots, as the node that serves them knows them, in words."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Final

from seoro.bridges.leasing.latch import in_words
from seoro.bridges.serving.node import CALLED
from seoro.bridges.wire.lab import LabState, RobotState
from seoro.doctor.findings import Finding, failed, ok, warning
from seoro.lab.readiness import unready
from seoro.lab.schema import BeforeFile

LONG_AGO: Final = 5.0  # [s] since a robot was heard of: they tell of themselves many times a second
NOW: Final = 0.5  # [s] ago, and less
LOW: Final = 0.15  # charge of a battery
_HOP: Final = (
    "check that the robot is on and its ROS 2 system runs, and that the bridge has its endpoint (`--ros`), "
    "domain and namespace; `seoro ros topic list` shows what there is"
)


def tell_robot(what: str, lab: LabState, robot: RobotState, before: BeforeFile | None) -> Iterator[Finding]:
    """A robot: whether it is there and heard of, who has it, and what is wrong with it.

    Args:
        what: How lines call it.
        lab: The node that it lives at.
        robot: How it is.
        before: What a lab file asks of it before a run; None if it says nothing of it.
    """
    silent = _silence(robot)
    if robot.seen is None and lab.kind == CALLED:
        yield failed(what, f"nothing was ever heard of it{silent}", _HOP)
        return
    if robot.seen is not None and robot.seen > LONG_AGO:
        yield failed(what, f"was last heard of {robot.seen:.0f} s ago{silent}", _HOP)
        return
    yield ok(what, ", ".join(_parts(lab, robot)))
    if robot.stopped is not None:
        advice = f"make sure that it is safe, then `seoro lab release --estop {robot.name} --reason ...`"
        yield failed(what, f"does not move: emergency stop by {in_words(robot.stopped)}", advice)
    asked = before or BeforeFile()
    if robot.battery is not None and robot.battery < LOW and asked.battery is None:
        yield warning(what, f"its battery is at {robot.battery:.0%}", "charge it")
    if silent:
        advice = "what needs these does not work: check what publishes them, and the profile of the robot"
        yield warning(what, f"is not heard on all its topics{silent}", advice)
    if found := unready(asked, robot):
        advice = "its `before` in the lab file asks for that: charge it, drive it there, or tell it where it is"
        yield warning(what, f"is not ready for runs: {'; '.join(found)}", advice)


def _parts(lab: LabState, robot: RobotState) -> Iterator[str]:
    """How it is, in words."""
    if robot.seen is not None:
        yield "heard of now" if robot.seen < NOW else f"heard of {robot.seen:.1f} s ago"
    if robot.holder:
        yield f"held by {robot.holder}"
    elif robot.lease is not None:
        until = time.strftime("%d %b %H:%M", time.localtime(robot.lease.until))
        yield f"leased until {until} ({robot.lease.purpose or robot.lease.lease})"
    elif lab.holder:
        yield f"held, with all of the node, by {lab.holder}"
    else:
        yield "free"
    if robot.waiting:
        yield f"{len(robot.waiting)} wait for it"
    if robot.localised is not None:
        known = "knows where it is" if robot.localised else "does not know where it is yet"
        yield known if robot.deviation is None or not robot.localised else f"{known}, to {robot.deviation:.2f} m"
    if robot.battery is not None:
        yield f"battery at {robot.battery:.0%}"


def _silence(robot: RobotState) -> str:
    """On which topics nothing is heard, and why."""
    found = [f"{each.topic} ({each.why})" for each in robot.topics if each.why]
    return f": {', '.join(found)}" if found else ""
