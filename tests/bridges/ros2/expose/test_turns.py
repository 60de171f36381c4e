"""Acceptance of navigation goals, with a simulator node that reaches all goals at once."""

from __future__ import annotations

from contextlib import AsyncExitStack
from functools import partial

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status
from seoro.bridges.ros2.expose.navigation import THROUGH_POSES, TO_POSE, RobotNavigation
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.sim.requests import R
from tests.bridges.ros2.expose.test_navigation import stamped


class Reaching(ExposedNode):
    """A node that reaches every goal."""

    def __init__(self) -> None:
        super().__init__(None)  # type: ignore[arg-type]

    async def pursue(self, verb: wire.Verb[R, wire.Empty], request: R) -> wire.Occurrence:
        await anyio.sleep(0.0)
        return wire.Occurrence(id="", time=1.0, outcome=wire.Outcome.SUCCEEDED)


def goal_to_pose(types: TypeStore, number: int) -> GoalHandle:
    goal = types.message("nav2_msgs/action/NavigateToPose_Goal", {"pose": stamped(1.0, 0.0)})
    return GoalHandle(bytes([number] * 16), goal, lambda _: None)


async def test_goals_run_in_the_order_of_their_acceptance(types: TypeStore) -> None:
    navigation = RobotNavigation(Reaching(), "turtlebot4", lambda: None)
    first, second = goal_to_pose(types, 1), goal_to_pose(types, 2)
    assert navigation.accept(TO_POSE, first)
    assert not navigation.accept(THROUGH_POSES, second)  # though nothing is done for the first one yet
    assert navigation.accept(TO_POSE, second)
    ends: dict[GoalHandle, Status] = {}

    async def run(goal: GoalHandle) -> None:
        ends[goal] = (await goal.run(partial(navigation.execute, TO_POSE))).status

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(run, first)
        tasks.start_soon(run, second)
    assert ends == {first: Status.ABORTED, second: Status.SUCCEEDED}
    assert navigation.accept(THROUGH_POSES, goal_to_pose(types, 3))


async def test_a_goal_canceled_before_its_start_frees_its_turn(types: TypeStore) -> None:
    navigation = RobotNavigation(Reaching(), "turtlebot4", lambda: None)
    goal, end = goal_to_pose(types, 1), GoalEnd(Status.CANCELED)
    assert navigation.accept(TO_POSE, goal)
    goal.stop(end)
    assert await goal.run(partial(navigation.execute, TO_POSE)) is end
    assert navigation.accept(THROUGH_POSES, goal_to_pose(types, 2))


async def test_receivers_of_feedback_unsubscribe_in_any_order() -> None:
    node = Reaching()
    received: list[object] = []
    async with AsyncExitStack() as first:
        await first.enter_async_context(node.receiving_feedback("turtlebot4", lambda _: None))
        async with node.receiving_feedback("turtlebot4", received.append):
            await first.aclose()
            assert node._on_feedback == {"turtlebot4": received.append}
    assert node._on_feedback == {}
