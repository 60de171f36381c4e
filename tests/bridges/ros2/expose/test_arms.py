from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.clients.goals import sending_goal
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.wire import LATCHED
from seoro.runtime.contracts.backends import GoalStatus
from tests.bridges.ros2.expose.exposed import Exposed, exposed, first, step

pytestmark = pytest.mark.engine("mujoco")

TRAJECTORY = "/ur10e/joint_trajectory_controller/follow_joint_trajectory"
GRIPPER = "/ur10e/gripper_controller/gripper_cmd"
TYPES = {TRAJECTORY: "control_msgs/action/FollowJointTrajectory", GRIPPER: "control_msgs/action/GripperCommand"}


async def reach(node: Exposed, action: str, goal: dict[str, Any]) -> tuple[GoalStatus, Mapping[str, Any]]:
    with anyio.fail_after(20.0):
        async with sending_goal(node.ros, action, TYPES[action], goal, lambda _: None) as pursued:
            ended = await pursued.ended()
    return ended.status, ended.result


async def duration_of_motion(node: Exposed) -> float:
    """Wait for a trajectory, and return its remaining duration [s]; no simulated time passes."""
    with anyio.fail_after(30.0):
        while (state := await node.ask(wire.GET_ARM_STATE, wire.RobotName(robot="ur10e"))).remaining == 0.0:
            pass
    return state.remaining


async def test_an_arm_follows_trajectories_in_their_time(simulator: str, router: str, types: TypeStore) -> None:
    async with (
        exposed(simulator, router, types, "arm_cell") as node,
        node.ros.subscribing("/ur10e/joint_states", "sensor_msgs/msg/JointState") as states,
        node.ros.subscribing("/ur10e/tf", "tf2_msgs/msg/TFMessage") as tf,
        node.ros.subscribing("/ur10e/tf_static", "tf2_msgs/msg/TFMessage", LATCHED) as tf_static,
    ):
        await step(node, 10)
        [state] = await first(states)
        names = list(state.name)[:6]
        assert {each.child_frame_id for each in (await first(tf))[0].transforms} >= {"wrist_3_link", "left_finger"}
        assert "map" in {each.header.frame_id for each in (await first(tf_static))[0].transforms}
        home = list(state.position)[:6]
        points = [
            {"positions": [home[0] + turn, *home[1:]], "time_from_start": {"sec": sec}}
            for turn, sec in ((0.1, 2), (0.2, 4))
        ]
        goal = {"trajectory": {"joint_names": names, "points": points}}
        async with sending_goal(node.ros, TRAJECTORY, TYPES[TRAJECTORY], goal, lambda _: None) as pursued:
            assert await duration_of_motion(node) == pytest.approx(4.0, rel=0.1)
            playing = wire.SetSimulationState(state=wire.SimulationState.PLAYING, rate=20.0)
            await node.ask(wire.SET_SIMULATION_STATE, playing)
            assert (await pursued.ended()).status is GoalStatus.SUCCEEDED
        joints = await node.ask(wire.GET_JOINT_STATES, wire.RobotName(robot="ur10e"))
        assert joints.positions[0] == pytest.approx(home[0] + 0.2, abs=0.01)
        wrong = {"trajectory": {"joint_names": ["elbow"], "points": [{"positions": [1.0]}]}}
        status, result = await reach(node, TRAJECTORY, wrong)
        assert (status, result["error_code"]) == (GoalStatus.ABORTED, -1)
        assert "elbow" in result["error_string"]


async def test_a_gripper_opens_and_closes(simulator: str, router: str, types: TypeStore) -> None:
    async with exposed(simulator, router, types, "arm_cell", 20.0) as node:
        status, result = await reach(node, GRIPPER, {"command": {"position": 0.03}})
        assert (status, result["reached_goal"], result["stalled"]) == (GoalStatus.SUCCEEDED, True, False)
        assert result["position"] == pytest.approx(0.03, abs=2e-3)
        status, _ = await reach(node, GRIPPER, {"command": {"position": 9.0}})
        assert status is GoalStatus.ABORTED
