"""Which robot of a lab is which actor: that of its name, or any that is free and fits what is wished for.

`--set robot=any:turtlebot4` wishes for a robot of that type, or with that capability; `--set robot=robot:tb1` for
one by its name. Of those that fit, the first in the order of the file that is free and ready gets the part.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.robot.connecting import RobotsTaken
from seoro.errors import BackendUnreachable, InvalidUse
from seoro.lab.readiness import hindrances
from seoro.lab.reading import Lab
from seoro.lab.wishes import Wish

States = Mapping[str, wire.RobotState | str]
"""How robots are, by their names in the lab; for those that cannot be asked, why."""


def bind(
    lab: Lab, actors: Collection[str], wishes: Mapping[str, Wish], states: States, lease: str, *, may_wait: bool
) -> dict[str, str]:
    """Choose a robot of the lab for each actor that has one.

    Args:
        lab: The lab.
        actors: Names of the actors of the scenario.
        wishes: What actors are to be, for whom that is said.
        states: How the robots are; needed for wishes only.
        lease: Id of the lease by hand that the run has.
        may_wait: Whether an actor may get a robot that another has now, where there is no other.

    Returns:
        The names of robots in the lab, by those of actors.

    Raises:
        RobotsTaken: Others have all robots that fit.
        BackendUnreachable: Robots that may fit are behind nodes that do not answer.
        InvalidUse: No robot fits, or there is no such actor.
    """
    for actor in wishes:
        if actor not in actors:
            known = ", ".join(sorted(actors)) or "none"
            raise InvalidUse(f"the scenario has no actor '{actor}' to be a robot", help=f"actors: {known}")
    own = (name for name in lab.robots if name in actors or not _is_anybodys(lab, name))
    bound = {name: name for name in own if name not in wishes}
    for actor, wish in sorted(wishes.items(), key=lambda each: not each[1].is_name):  # those by name come first
        taken = {*bound.values()}
        bound[actor] = (
            _named(lab, actor, wish, taken)
            if wish.is_name
            else _any(lab, actor, wish, states, taken, lease, may_wait=may_wait)
        )
    return bound


def _is_anybodys(lab: Lab, name: str) -> bool:
    """Whether a robot need not be an actor's of its name."""
    robot = lab.robots[name]
    return robot.type is not None or bool(robot.can)


def _named(lab: Lab, actor: str, wish: Wish, taken: Collection[str]) -> str:
    if wish.word not in lab.robots:
        raise InvalidUse(
            f"`{actor}` is to be the robot '{wish.word}', which the lab does not have",
            help=f"robots of the lab: {', '.join(sorted(lab.robots)) or 'none'}",
        )
    if wish.word in taken:
        raise InvalidUse(f"`{actor}` is to be the robot '{wish.word}', which another actor is already")
    return wish.word


def _any(
    lab: Lab, actor: str, wish: Wish, states: States, taken: Collection[str], lease: str, *, may_wait: bool
) -> str:
    fitting = [name for name in lab.robots if _fits(lab, name, wish.word, states)]
    unreachable = {name: state for name in lab.robots if isinstance(state := states.get(name), str)}
    if not fitting and unreachable:
        why_not = "; ".join(f"{name}: {state}" for name, state in unreachable.items())
        raise BackendUnreachable(
            f"`{actor}` is to be any '{wish.word}', and no robot is known to be one ({why_not})"
        )
    if not fitting:
        words = sorted({word for robot in lab.robots.values() for word in (robot.type, *robot.can) if word})
        raise InvalidUse(
            f"`{actor}` is to be any '{wish.word}', and the lab has none",
            help=f"types and capabilities in the lab: {', '.join(words) or 'none are declared'}",
        )
    why, patient = [], list[str]()
    for name in fitting:
        if name in taken:
            why.append(f"{name}: another actor is that already")
            continue
        unready, occupied = hindrances(lab.robots[name].before, states[name], lease)
        if not unready and not occupied:
            return name
        if not unready:
            patient.append(name)
        why.append(f"{name}: {'; '.join((*unready, *occupied))}")
    if patient and may_wait:
        return patient[0]
    message = f"`{actor}` is to be any '{wish.word}', and none can be had: {' - '.join(why)}"
    if patient:
        raise RobotsTaken(message)
    raise BackendUnreachable(message) if unreachable.keys() & set(fitting) else InvalidUse(message)


def _fits(lab: Lab, name: str, word: str, states: States) -> bool:
    robot, state = lab.robots[name], states.get(name)
    kinds: Sequence[str] = state.kinds if isinstance(state, wire.RobotState) else ()
    return word == robot.type or word in robot.can or word in kinds
