"""The robots of a lab as a table, for `seoro lab status`."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

from seoro.cli.output import printable

if TYPE_CHECKING:
    from seoro.bridges.wire import LabState, RobotState
    from seoro.lab.seeing import Member

_TITLES: Final = ("ROBOT", "TYPE", "NODE", "STATE", "BATTERY", "LOCALISED", "SEEN", "BY", "WAITING")
NOTHING: Final = "-"


def plain(members: Sequence[Member]) -> dict[str, Any]:
    """All that is known, for programs."""
    return {
        "nodes": [
            {
                "endpoint": member.endpoint,
                "node": member.node,
                "kind": "executor" if member.is_executor else "node",
                "error": member.why,
                **({} if member.state is None else member.state.model_dump(mode="json")),
            }
            for member in members
        ]
    }


def table(members: Sequence[Member], *, quiet: Sequence[str]) -> str:
    """The robots, and what is wrong with nodes; `quiet` about endpoints at which nobody has to live."""
    lines = list(_headlines(members))
    known = [(member.node, member.state) for member in members if member.state is not None]
    rows = [_row(node, state, robot) for node, state in known for robot in state.robots]
    if rows:
        lines += _aligned([_TITLES, *rows])
    elif not any(member.node for member in members):
        lines.append("nobody is there: `--lab` or `--connect` says where the lab is")
    else:
        lines.append("there are no robots")
    lines += [f"{each.called}: {each.why}" for each in members if each.why and each.called not in quiet]
    executors = [f"{member.node} ({member.endpoint})" for member in members if member.is_executor]
    if executors:
        lines.append(f"executors: {', '.join(executors)}")
    return "\n".join(printable(line) for line in lines)


def _headlines(members: Sequence[Member]) -> Iterator[str]:
    for member in members:
        stopped = None if member.state is None else member.state.stopped
        if stopped is not None:
            when = time.strftime("%d %b %X", time.localtime(stopped.since))
            why = f": {stopped.reason}" if stopped.reason else ""
            yield f"EMERGENCY STOP of {member.node} by {stopped.by} at {when}{why}"


def _row(node: str, lab: LabState, robot: RobotState) -> tuple[str, ...]:
    by = robot.holder
    if not by and robot.lease is not None:
        until = time.strftime("%H:%M", time.localtime(robot.lease.until))
        by = f"{robot.lease.purpose} until {until} ({robot.lease.lease})"
    return (
        robot.name,
        next(iter(robot.kinds), NOTHING),
        f"{node} ({lab.kind})",
        _state(lab, robot),
        NOTHING if robot.battery is None else f"{robot.battery:.0%}",
        _localised(robot),
        NOTHING if robot.seen is None else f"{robot.seen:.1f} s ago" if robot.seen >= 0.1 else "now",
        by or NOTHING,
        ", ".join(robot.waiting) or NOTHING,
    )


def _state(lab: LabState, robot: RobotState) -> str:
    if lab.stopped is not None:
        return "stopped"
    if robot.holder:
        return "in use"
    return "free" if robot.lease is None else "leased"


def _localised(robot: RobotState) -> str:
    if robot.localised is None:
        return NOTHING
    if not robot.localised:
        return "no"
    return "yes" if robot.deviation is None else f"to {robot.deviation:.2f} m"


def _aligned(rows: list[tuple[str, ...]]) -> list[str]:
    kept = [index for index in range(len(rows[0])) if any(row[index] != NOTHING for row in rows[1:])]
    widths = {index: max(len(row[index]) for row in rows) for index in kept}
    return ["  ".join(f"{row[index]:{widths[index]}}" for index in kept).rstrip() for row in rows]
