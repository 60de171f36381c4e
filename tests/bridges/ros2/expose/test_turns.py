"""Which goals of a robot's navigation are accepted, beside a simulator node that reaches them all at once."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AsyncExitStack
from functools import partial

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2.action_server import GoalEnd, ServedGoal, Status
from seoro.bridges.ros2.expose.navigation import THROUGH_POSES, TO_POSE, RobotNavigation
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.interfaces import TypeStore
from tests.bridges.ros2.expose.test_navigation import stamped


class Reaching(ExposedNode):
    """A node that reaches every goal."""

    def __init__(self) -> None:
        super().__init__(None)  # type: ignore[arg-type]

    async def pursue(
        self, verb: wire.Verb[wire.Q, wire.Empty], request: Callable[[str], wire.Q]
    ) -> wire.Occurrence:
        await anyio.sleep(0.0)
        return wire.Occurrence(id="", time=1.0, outcome=wire.Outcome.SUCCEEDED)


def goal_to_pose(types: TypeStore, number: int) -> ServedGoal:
    goal = types.message("nav2_msgs/action/NavigateToPose_Goal", {"pose": stamped(1.0, 0.0)})
    return ServedGoal(bytes([number] * 16), goal, lambda _: None)


async def test_a_goal_has_its_turn_from_when_it_is_accepted(types: TypeStore) -> None:
    navigation = RobotNavigation(Reaching(), "turtlebot4", lambda: None)
    first, second = goal_to_pose(types, 1), goal_to_pose(types, 2)
    assert navigation.accept(TO_POSE, first)
    assert not navigation.accept(THROUGH_POSES, second)  # though nothing is done for the first one yet
    assert navigation.accept(TO_POSE, second)
    ends: dict[ServedGoal, Status] = {}

    async def run(goal: ServedGoal) -> None:
        ends[goal] = (await goal.carry_out(partial(navigation.carry_out, TO_POSE))).status

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(run, first)
        tasks.start_soon(run, second)
    assert ends == {first: Status.ABORTED, second: Status.SUCCEEDED}
    assert navigation.accept(THROUGH_POSES, goal_to_pose(types, 3))


async def test_a_goal_that_is_called_off_before_it_is_begun_leaves_its_turn(types: TypeStore) -> None:
    navigation = RobotNavigation(Reaching(), "turtlebot4", lambda: None)
    goal, end = goal_to_pose(types, 1), GoalEnd(Status.CANCELED)
    assert navigation.accept(TO_POSE, goal)
    goal.stop(end)
    assert await goal.carry_out(partial(navigation.carry_out, TO_POSE)) is end
    assert navigation.accept(THROUGH_POSES, goal_to_pose(types, 2))


async def test_those_who_are_told_of_one_robots_way_may_leave_in_any_order() -> None:
    node = Reaching()
    async with AsyncExitStack() as first:
        await first.enter_async_context(node.on_its_way("turtlebot4", lambda _: None))
        async with node.on_its_way("turtlebot4", lambda _: None):
            await first.aclose()
