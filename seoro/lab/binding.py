"""Assignment of lab robots to actors, by name or by a selector.

`--set robot=any:turtlebot4` selects a robot of that type or with that capability; `--set robot=robot:tb1` selects
one by name. Of the matching robots, the first in file order that is free and ready is assigned.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.robot.connecting import RobotsBusy
from seoro.errors import BackendUnreachable, UsageError
from seoro.lab.readiness import conflicts
from seoro.lab.reading import Lab
from seoro.lab.selectors import Selector

States = Mapping[str, wire.RobotState | str]
"""States of robots by their names in the lab, or the reason if a robot cannot be queried."""


def bind(
    lab: Lab,
    actors: Collection[str],
    selectors: Mapping[str, Selector],
    states: States,
    lease: str,
    *,
    may_wait: bool,
) -> dict[str, str]:
    """Choose a robot of the lab for each actor that has one.

    Args:
        lab: The lab.
        actors: Names of the actors of the scenario.
        selectors: Selectors of actors that have one.
        states: States of the robots; needed for selectors only.
        lease: Id of the manual lease of the run.
        may_wait: Whether an actor may be assigned a busy robot if no other matches.

    Returns:
        The names of robots in the lab, by those of actors.

    Raises:
        RobotsBusy: Other clients hold all matching robots.
        BackendUnreachable: Robots that may match are behind nodes that do not answer.
        UsageError: No robot matches, or an actor is unknown.
    """
    for actor in selectors:
        if actor not in actors:
            known = ", ".join(sorted(actors)) or "none"
            raise UsageError(f"cannot select a robot for the unknown actor '{actor}'", help=f"actors: {known}")
    own = (name for name in lab.robots if name in actors or not _is_shared(lab, name))
    bound = {name: name for name in own if name not in selectors}
    for actor, selector in sorted(selectors.items(), key=lambda item: not item[1].is_name):  # by name first
        taken = {*bound.values()}
        bound[actor] = (
            _select_named(lab, actor, selector, taken)
            if selector.is_name
            else _select_any(lab, actor, selector, states, taken, lease, may_wait=may_wait)
        )
    return bound


def _is_shared(lab: Lab, name: str) -> bool:
    """Whether a robot is not reserved for the actor of its name."""
    robot = lab.robots[name]
    return robot.type is not None or bool(robot.can)


def _select_named(lab: Lab, actor: str, selector: Selector, taken: Collection[str]) -> str:
    if selector.value not in lab.robots:
        raise UsageError(
            f"unknown robot '{selector.value}' for the actor `{actor}`",
            help=f"robots of the lab: {', '.join(sorted(lab.robots)) or 'none'}",
        )
    if selector.value in taken:
        raise UsageError(f"the robot '{selector.value}' is assigned to two actors, one of them is `{actor}`")
    return selector.value


def _select_any(
    lab: Lab, actor: str, selector: Selector, states: States, taken: Collection[str], lease: str, *, may_wait: bool
) -> str:
    matching = [name for name in lab.robots if _matches(lab, name, selector.value, states)]
    unreachable = {name: state for name in lab.robots if isinstance(state := states.get(name), str)}
    if not matching and unreachable:
        details = "; ".join(f"{name}: {state}" for name, state in unreachable.items())
        raise BackendUnreachable(
            f"no known '{selector.value}' for the actor `{actor}`; unknown types of robots: {details}"
        )
    if not matching:
        words = sorted({word for robot in lab.robots.values() for word in (robot.type, *robot.can) if word})
        raise UsageError(
            f"no '{selector.value}' in the lab for the actor `{actor}`",
            help=f"types and capabilities in the lab: {', '.join(words) or 'none are declared'}",
        )
    reasons, busy = list[str](), list[str]()
    for name in matching:
        if name in taken:
            reasons.append(f"{name}: assigned to another actor")
            continue
        unready, occupied = conflicts(lab.robots[name].before, states[name], lease)
        if not unready and not occupied:
            return name
        if not unready:
            busy.append(name)
        reasons.append(f"{name}: {'; '.join((*unready, *occupied))}")
    if busy and may_wait:
        return busy[0]
    message = f"no available '{selector.value}' for the actor `{actor}`: {' - '.join(reasons)}"
    if busy:
        raise RobotsBusy(message)
    raise BackendUnreachable(message) if unreachable.keys() & set(matching) else UsageError(message)


def _matches(lab: Lab, name: str, word: str, states: States) -> bool:
    robot, state = lab.robots[name], states.get(name)
    kinds: Sequence[str] = state.kinds if isinstance(state, wire.RobotState) else ()
    return word == robot.type or word in robot.can or word in kinds
