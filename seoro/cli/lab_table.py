"""Table of the robots of a lab, for `seoro lab status`."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from seoro.cli.tables import table
from seoro.lab.status import state_of
from seoro.text.printable import one_line

if TYPE_CHECKING:
    from seoro.bridges.wire import ActiveStop, RobotState
    from seoro.lab.recorded import RecordedRobot
    from seoro.lab.status import ListedRobot, Member

_TITLES: Final = ("ROBOT", "TYPE", "AT", "STATE", "BATTERY", "LOCALISED", "SEEN", "BY", "WAITING")
NOTHING: Final = "-"
NOW: Final = 0.5  # [s], longest age that is shown as "now"


def plain(members: Sequence[Member], recorded: Sequence[RecordedRobot]) -> dict[str, Any]:
    """Return all details as JSON data."""
    return {
        **({"recorded": [asdict(each) for each in recorded]} if recorded else {}),
        "nodes": [
            {
                "endpoint": member.endpoint,
                "node": member.node,
                "kind": "executor" if member.is_executor else "node",
                "error": member.problem,
                **({} if member.state is None else member.state.model_dump(mode="json")),
            }
            for member in members
        ],
    }


def lab_table(
    members: Sequence[Member],
    known: Sequence[ListedRobot],
    recorded: Sequence[RecordedRobot] = (),
    *,
    quiet: Sequence[str],
) -> str:
    """Format the robots, and the problems of nodes.

    Args:
        members: Nodes and executors that were found.
        known: Robots of the lab file, listed first.
        recorded: Recorded robots of the lab file.
        quiet: Optional endpoints, without errors if nothing answers there.
    """
    lines = list(_headlines(members))
    rows = [*_rows(members, known), *map(_recorded_row, recorded)]
    if rows:
        lines += table(_without_empty_columns([_TITLES, *rows])).split("\n")
    elif not any(member.node for member in members):
        lines.append("no node was reached; select the lab with `--lab` or `--connect`")
    else:
        lines.append("no robots")
    lines += [
        f"{each.display_name}: {each.problem}"
        for each in members
        if each.problem and each.display_name not in quiet
    ]
    lines += [f"{each.name}: {each.problem}" for each in recorded if each.problem]
    executors = [f"{member.node} ({member.endpoint})" for member in members if member.is_executor]
    if executors:
        lines.append(f"executors: {', '.join(executors)}")
    return "\n".join(one_line(line) for line in lines)


def _rows(members: Sequence[Member], known: Sequence[ListedRobot]) -> Iterator[tuple[str, ...]]:
    """Yield a row per robot: those of the lab file in its order, then all others."""
    served = [(member, state) for member in members for state in member.robots]
    shown: list[tuple[Member, RobotState]] = []
    for each in known:
        found = [one for one in served if each.is_served_by(one[0]) and one[1].name == each.remote_name]
        shown += found
        for member, state in found:
            yield _row(each.name, each.type, member, state)
        if not found:
            yield _short_row(each.name, each.type, each.remote_name, "not found")
    for member, state in served:
        if (member, state) not in shown:
            yield _row(state.name, "", member, state)


def _short_row(name: str, kind: str, place: str, state: str) -> tuple[str, ...]:
    """Return the row of a robot without a node."""
    return name, kind or NOTHING, place, state, *(NOTHING,) * (len(_TITLES) - 4)


def _recorded_row(robot: RecordedRobot) -> tuple[str, ...]:
    place = f"bag {robot.bag}" + (f" ({robot.contents})" if robot.contents else "")
    return _short_row(robot.name, robot.type, place, "unreadable" if robot.problem else "recorded")


def _headlines(members: Sequence[Member]) -> Iterator[str]:
    for member in members:
        if member.state is not None and member.state.stopped is not None:
            yield _headline(member.node, member.state.stopped)
        for robot in member.robots:
            if robot.stopped is not None:
                yield _headline(f"{robot.name} of {member.node}", robot.stopped)


def _headline(what: str, stopped: ActiveStop) -> str:
    when = time.strftime("%d %b %X", time.localtime(stopped.since))
    reason = f": {stopped.reason}" if stopped.reason else ""
    return f"EMERGENCY STOP of {what} by {stopped.by} at {when}{reason}"


def _row(name: str, kind: str, member: Member, robot: RobotState) -> tuple[str, ...]:
    lab = member.state
    assert lab is not None
    by = robot.holder
    if not by and robot.lease is not None:
        until = time.strftime("%H:%M", time.localtime(robot.lease.until))
        by = f"{robot.lease.purpose} until {until} ({robot.lease.lease})"
    return (
        name,
        kind or next(iter(robot.kinds), NOTHING),
        f"{robot.name} of {member.node} ({lab.kind})",
        state_of(lab, robot),
        NOTHING if robot.battery is None else f"{robot.battery:.0%}",
        _localised(robot),
        _seen(robot),
        by or NOTHING,
        ", ".join(robot.waiting) or NOTHING,
    )


def _seen(robot: RobotState) -> str:
    if robot.seen is None:
        return NOTHING
    return f"{robot.seen:.1f} s ago" if robot.seen >= NOW else "now"


def _localised(robot: RobotState) -> str:
    if robot.localised is None:
        return NOTHING
    if not robot.localised:
        return "no"
    return "yes" if robot.deviation is None else f"within {robot.deviation:.2f} m"


def _without_empty_columns(rows: list[tuple[str, ...]]) -> list[list[str]]:
    kept = [index for index in range(len(rows[0])) if any(row[index] != NOTHING for row in rows[1:])]
    return [[row[index] for index in kept] for row in rows]
