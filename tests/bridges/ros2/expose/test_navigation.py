from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.errors import GoalRejected
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.runtime.contracts.backends import GoalStatus
from tests.bridges.ros2.expose.exposed import Exposed, exposed, under_way
from tests.sim_nodes.client import pose

pytestmark = pytest.mark.engine("mujoco")

FAST = 20.0  # times as fast as the machine's clock


def stamped(x: float, y: float, frame: str = "map") -> dict[str, Any]:
    return {
        "header": {"frame_id": frame},
        "pose": {"position": {"x": x, "y": y}, "orientation": {"w": 1.0}},
    }


@asynccontextmanager
async def localised(simulator: str, router: str, types: TypeStore) -> AsyncIterator[Exposed]:
    async with exposed(simulator, router, types, "maze", FAST) as node:
        await node.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot="turtlebot4", pose=pose(0.0, 0.0)))
        yield node


class Robot:
    """An action client that sends goals and keeps their feedback and results."""

    def __init__(self, node: Exposed) -> None:
        self._node = node
        self.reported: list[Members] = []

    @asynccontextmanager
    async def pursuing(self, action: str, goal: Mapping[str, Any]) -> AsyncIterator[Goal]:
        kind = "".join(word.capitalize() for word in action.split("_"))
        with anyio.fail_after(20.0):
            async with sending_goal(
                self._node.ros, f"/turtlebot4/{action}", f"nav2_msgs/action/{kind}", goal, self.reported.append
            ) as pursued:
                yield pursued

    async def reach(self, action: str, goal: Mapping[str, Any]) -> tuple[GoalStatus, Mapping[str, Any]]:
        async with self.pursuing(action, goal) as pursued:
            ended = await pursued.ended()
        return ended.status, ended.result


async def test_the_navigation_of_the_node_reaches_goals(simulator: str, router: str, types: TypeStore) -> None:
    async with localised(simulator, router, types) as node:
        robot = Robot(node)
        assert set(node.ros.graph.actions()) >= {
            f"/turtlebot4/{name}" for name in ("navigate_to_pose", "navigate_through_poses", "follow_waypoints")
        }
        status, result = await robot.reach("navigate_to_pose", {"pose": stamped(0.5, -0.5)})
        assert (status, result["error_msg"]) == (GoalStatus.SUCCEEDED, "")
        truth = (await node.ask(wire.GET_ENTITY_STATE, wire.EntityName(name="turtlebot4"))).pose.position
        assert truth.x == pytest.approx(0.5, abs=0.3)
        assert robot.reported
        assert 0.0 <= robot.reported[-1]["distance_remaining"] < 0.7
        assert robot.reported[-1]["current_pose"]["header"]["frame_id"] == "map"
        robot.reported.clear()
        status, _ = await robot.reach("follow_waypoints", {"poses": [stamped(0.4, 0.0), stamped(0.2, 0.0)]})
        assert status is GoalStatus.SUCCEEDED
        assert [reported["current_waypoint"] for reported in robot.reported] == [0, 1]


async def test_unreachable_goals_are_aborted_with_the_reason(
    simulator: str, router: str, types: TypeStore
) -> None:
    async with localised(simulator, router, types) as node:
        robot = Robot(node)
        status, result = await robot.reach("navigate_to_pose", {"pose": stamped(99.0, 0.0)})
        assert (status, result["error_code"]) == (GoalStatus.ABORTED, 9000)
        assert "99" in result["error_msg"]
        status, result = await robot.reach("navigate_through_poses", {"poses": [stamped(0.5, 0.0, "odom")]})
        assert "unsupported frame 'odom' of the goal: expected 'map'" in result["error_msg"]
        for nowhere, count in ({"number_of_loops": 3}, 0), ({"poses": [stamped(0.2, 0.0)], "goal_index": 1}, 1):
            status, result = await robot.reach("follow_waypoints", nowhere)
            assert (status, result["error_code"]) == (GoalStatus.ABORTED, 9000)
            assert result["error_msg"].endswith(f"(number of waypoints: {count})")
        waypoints = {"poses": [stamped(0.2, 0.0), stamped(99.0, 0.0)]}
        status, result = await robot.reach("follow_waypoints", waypoints)
        assert status is GoalStatus.ABORTED
        assert [missed["index"] for missed in result["missed_waypoints"]] == [1]


async def test_goals_are_canceled_replaced_and_rejected(simulator: str, router: str, types: TypeStore) -> None:
    far = {"pose": stamped(3.0, -3.0)}
    async with localised(simulator, router, types) as node:
        robot = Robot(node)
        async with robot.pursuing("navigate_to_pose", far) as first:
            with pytest.raises(GoalRejected):
                await robot.reach("navigate_through_poses", {"poses": [stamped(0.5, 0.0)]})
            async with robot.pursuing("navigate_to_pose", {"pose": stamped(2.0, -2.0)}) as second:
                ended = await first.ended()
                assert ended.status is GoalStatus.ABORTED
                assert ended.result["error_msg"] == "replaced by another goal"
                await second.cancel()
                assert (await second.ended()).status is GoalStatus.CANCELED
        # No earlier goal remains.
        status, _ = await robot.reach("navigate_through_poses", {"poses": [stamped(0.2, 0.0)]})
        assert status is GoalStatus.SUCCEEDED


async def test_a_reset_ends_goals(simulator: str, router: str, types: TypeStore) -> None:
    async with localised(simulator, router, types) as node:
        robot = Robot(node)
        async with (
            robot.pursuing("navigate_to_pose", {"pose": stamped(3.0, -3.0)}) as goal,
            node.ros.calling("/reset_simulation", "simulation_interfaces/srv/ResetSimulation") as reset,
        ):
            await under_way(node)
            assert (await reset.call({}, 5.0)).result.result == 1
            ended = await goal.ended()
            assert (ended.status, ended.result["error_msg"]) == (
                GoalStatus.ABORTED,
                "the simulation was started over",
            )
