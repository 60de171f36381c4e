"""State of a lab as JSON data for pages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from seoro.lab.status import state_of

if TYPE_CHECKING:
    from seoro.bridges.wire import ActiveStop, LabState, RobotState
    from seoro.lab.recorded import RecordedRobot
    from seoro.lab.status import ListedRobot, Member
    from seoro.ui.lab_watch import Seen

BAG: Final = "bag"  # kind of the member with the recorded robots of a lab file
BRIDGE: Final = "bridge"  # kind of nodes with real robots; other nodes are simulators
EXECUTOR: Final = "executor"
NOW: Final = 1.0  # [s], longest age that is shown as "now"


def snapshot_of(
    members: Sequence[Seen], listed: Sequence[ListedRobot], recorded: Sequence[RecordedRobot] = ()
) -> Mapping[str, Any]:
    """Return the state of a lab.

    Args:
        members: Its members.
        listed: Robots of its lab file, which come first.
        recorded: Recorded robots of its lab file.
    """
    found = [_member(seen, [each for each in listed if each.endpoint == seen.member.endpoint]) for seen in members]
    found += [_bag(recorded)] if recorded else []
    return {"members": found, "stopped": _stopped(members)}


def _bag(recorded: Sequence[RecordedRobot]) -> Mapping[str, Any]:
    """Return the member with the recorded robots, which have one bag."""
    return {
        "name": "recorded robots",
        "endpoint": recorded[0].bag,
        "kind": BAG,
        "problem": "",
        "stopped": "",
        "robots": [
            {
                **_UNUSED,
                "name": each.name,
                "there": each.name,
                "type": each.type,
                "state": "unreadable" if each.problem else "recorded",
                "detail": each.problem or each.contents,
            }
            for each in recorded
        ],
    }


def _stopped(members: Sequence[Seen]) -> Mapping[str, Any] | None:
    """Return the emergency stop of whole members, the earliest; None without one."""
    stops = [
        seen.member.state.stopped
        for seen in members
        if seen.member.state is not None and seen.member.state.stopped is not None
    ]
    held = [seen.stopped for seen in members if seen.stopped]
    if not stops and not held:
        return None
    known = sum(
        seen.member.state is not None or (seen.member.is_executor and not seen.member.problem) for seen in members
    )
    counts = {"count": len(stops) + len(held), "of": known}
    if not stops:
        return {"reason": held[0], "by": "", "since": None, **counts}
    first = min(stops, key=lambda stop: stop.since)
    return {"reason": first.reason, "by": first.by, "since": first.since, **counts}


def _member(seen: Seen, listed: Sequence[ListedRobot]) -> Mapping[str, Any]:
    member, state = seen.member, seen.member.state
    kind = EXECUTOR if member.is_executor else "" if state is None else state.kind
    return {
        "name": member.node,
        "endpoint": member.endpoint,
        "kind": kind,
        "problem": member.problem,
        "stopped": seen.stopped or (_stop_text(state.stopped) if state is not None else ""),
        "robots": list(_robots(member, listed)),
    }


def _robots(member: Member, listed: Sequence[ListedRobot]) -> Iterator[Mapping[str, Any]]:
    """Yield the robots of a member: those of the lab file in its order, then all others."""
    states = {robot.name: robot for robot in member.robots}
    mine = [each for each in listed if each.is_served_by(member)]
    for each in mine:
        state = states.get(each.remote_name)
        if state is not None and member.state is not None:
            yield _robot(each.name, each.type, member.state, state)
        elif member.state is not None:
            yield _missing(each)
    named = {each.remote_name for each in mine}
    for name, state in states.items():
        if name not in named and member.state is not None:
            yield _robot(name, "", member.state, state)


_UNUSED: Final[Mapping[str, Any]] = {
    "real": None,
    "holder": "",
    "lease": None,
    "until": None,
    "queue": [],
    "stopped": None,
}
"""Fields of a robot without a node."""


def _missing(listed: ListedRobot) -> Mapping[str, Any]:
    return {
        **_UNUSED,
        "name": listed.name,
        "there": listed.remote_name,
        "type": listed.type,
        "state": "not found",
        "detail": f"the node has no robot '{listed.remote_name}'",
    }


def _robot(name: str, type_: str, lab: LabState, robot: RobotState) -> Mapping[str, Any]:
    lease = robot.lease
    return {
        "name": name,
        "there": robot.name,
        "type": type_ or next(iter(robot.kinds), ""),
        "real": lab.kind == BRIDGE,
        "state": state_of(lab, robot),
        "detail": ", ".join(_details(robot)),
        "holder": robot.holder or (lease.purpose if lease is not None else ""),
        "lease": None if lease is None else lease.lease,
        "until": None if lease is None else lease.until,
        "queue": list(robot.waiting),
        "stopped": _stop_text(robot.stopped) or None,
    }


def _details(robot: RobotState) -> Iterator[str]:
    if robot.battery is not None:
        yield f"battery {robot.battery:.0%}"
    if robot.localised is False:
        yield "not localised"
    elif robot.localised:
        yield "localised" if robot.deviation is None else f"localised within {robot.deviation:.2f} m"
    if robot.seen is not None and robot.seen >= NOW:
        yield f"last message {robot.seen:.0f} s ago"
    yield from (f"{topic.topic}: {topic.why}" for topic in robot.topics if topic.why)


def _stop_text(stop: ActiveStop | None) -> str:
    if stop is None:
        return ""
    return f"emergency stop by {stop.by}" + (f": {stop.reason}" if stop.reason else "")
