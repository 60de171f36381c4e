"""Decisions of robots that are due in the same tick.

Controllers `arcs` of a kind are asked together, because most of the time of small arrays is that of calls. Others,
also classes below `ArcController`, are asked one at a time.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from sim_nodes.navigation.contracts import ControlInput, Controller, Following
from sim_nodes.navigation.controller import ArcController, follow_together
from sim_nodes.navigation.navigator import Navigator
from sim_nodes.outcomes import GoalResult
from sim_nodes.robots.kinematics import Velocity


def decide(due: Sequence[tuple[Navigator, ControlInput]]) -> list[GoalResult | None]:
    """Decide on the velocities of robots from now on.

    Args:
        due: Navigators with a goal, and their inputs.

    Returns:
        For each, the result of its goal if it ends.
    """
    decided = [navigator.decide(now) for navigator, now in due]
    velocities = iter(_velocities([each for each in decided if isinstance(each, Following)]))
    return [
        navigator.drive(now, next(velocities)) if isinstance(each, Following) else each
        for (navigator, now), each in zip(due, decided, strict=True)
    ]


def _velocities(calls: Sequence[Following[Controller]]) -> list[Velocity | None]:
    """Return what controllers answer to calls of `follow`."""
    found: list[Velocity | None] = [None] * len(calls)
    together: dict[tuple[int, int], dict[int, Following[ArcController]]] = defaultdict(dict)
    for number, call in enumerate(calls):
        controller = call.controller
        if type(controller) is ArcController:
            together[controller.kind][number] = Following(controller, call.path, call.now, call.stops)
        else:
            found[number] = controller.follow(call.path, call.now, stops=call.stops)
    for group in together.values():
        for number, velocity in zip(group, follow_together(list(group.values())), strict=True):
            found[number] = velocity
    return found
