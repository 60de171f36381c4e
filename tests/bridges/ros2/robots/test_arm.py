"""A ROS 2 arm behind the bridge."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.robots import MotionOptions
from seoro.runtime.verdict import RunStatus
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.robots.conftest import BRIDGE, run_on_robot
from tests.bridges.ros2.robots.fake_arm import NUMB
from tests.routers import free_endpoint, process, router_process

pytestmark = pytest.mark.anyio

FAKE_ARM = str(Path(__file__).with_name("fake_arm.py"))
ALL = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
MANNER = MotionOptions(0.5, 0.01, (), False)


@dataclass(frozen=True)
class BridgedArm:
    """Endpoint of the bridge, and file with the goals of the arm."""

    endpoint: str
    file: Path

    def goals(self, kind: str) -> list[dict[str, Any]]:
        """Return the goals that an action of the arm has received."""
        noted = [json.loads(line) for line in self.file.read_text().splitlines()]
        return [goal for name, goal in noted if name.endswith(kind)]


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BridgedArm]:
    """Yield an arm `planned` with MoveIt and an equal arm `plain` without, behind one bridge."""
    folder = tmp_path_factory.mktemp("arm")
    plain = folder / "plain.yaml"
    plain.write_text(
        "model: plain\nkinds: [arm]\narm:\n  joints: {shoulder_pan_joint: 2.0, elbow_joint: 1.0}\n"
        "  trajectory: scaled_joint_trajectory_controller/follow_joint_trajectory\n"
    )
    patient = (
        "import seoro.bridges.leasing.leases as leases\nleases.HOLD_DEADLINE = 20.0\n"  # a test may be delayed
    )
    bridge = patient + BRIDGE.replace('profile = read_profile("turtlebot4")', "").replace(
        "[BridgedRobot(name, profile,",
        f"[BridgedRobot(name, read_profile('ur10e' if name == 'planned' else {str(plain)!r}),",
    )
    router, endpoint = free_endpoint(), f"unixsock-stream/{folder}/bridge"
    with (
        router_process(router),
        process(FAKE_ARM, str(folder), router, "arm"),
        process("-c", bridge.replace('f"/{name}"', '"/arm"'), router, endpoint, "planned", "plain"),
    ):
        yield BridgedArm(endpoint, folder / "arm")


async def test_joints_are_moved_by_plans(arm: BridgedArm) -> None:
    end, passed = Ends(), Ends()
    async with connect_robots(arm.endpoint, "a test") as node:
        await node.watch_joint("planned", "elbow_joint", 0.2, 0.01, passed)
        await node.move_joints("planned", ALL, (), MANNER, end)
        assert (await end.wait()).status is GoalStatus.SUCCEEDED
        assert (await passed.wait()).status is GoalStatus.SUCCEEDED
        far = Ends()
        await node.move_joints("planned", (3.1, *ALL[1:]), (), MANNER, far)
        report = await far.wait()
        assert report.status is GoalStatus.ABORTED
        assert report.message == (
            "move_action: MoveIt: collision at the goal; look at the planning scene there "
            "(GOAL_IN_COLLISION, error -12)"
        )
    request = arm.goals("MoveGroup")[0]["request"]
    assert (request["group_name"], request["max_velocity_scaling_factor"]) == ("ur_manipulator", 0.5)
    wanted = request["goal_constraints"][0]["joint_constraints"]
    assert [(each["joint_name"], each["position"]) for each in wanted][2] == ("elbow_joint", 0.3)


async def test_tools_are_moved_to_poses_in_a_line_or_freely(arm: BridgedArm) -> None:
    goal = Pose3D(Position3D(x=0.5, z=0.4))
    async with connect_robots(arm.endpoint, "a test") as node:
        for straight in (False, True):
            end = Ends()
            await node.move_tool("planned", goal, "base_link", MANNER, end, straight=straight)
            assert (await end.wait()).status is GoalStatus.SUCCEEDED
    usual, line = (goal["request"] for goal in arm.goals("MoveGroup")[-2:])
    assert (usual["planner_id"], line["planner_id"]) == ("", "LIN")
    place = usual["goal_constraints"][0]["position_constraints"][0]
    assert (place["link_name"], place["header"]["frame_id"]) == ("tool0", "base_link")
    assert place["constraint_region"]["primitive_poses"][0]["position"] == {"x": 0.5, "y": 0.0, "z": 0.4}


async def test_scenarios_set_the_frame_of_poses_and_replanning(arm: BridgedArm, tmp_path: Path) -> None:
    text = """import osc.moveit2
scenario main:
    ur: arm with:
        keep(it.base_link == 'base')
        keep(it.arm_group == '')
        keep(it.gripper_group == '')
        keep(it.end_effector == '')
    do ur.move_to_pose(pose_3d(position_3d(x: 0.5m)), replan: WORTH_IT)
"""
    for replan in ("true", "false"):
        verdict = await run_on_robot(tmp_path, text.replace("WORTH_IT", replan), arm.endpoint, "ur", "planned")
        assert verdict.status is RunStatus.PASSED, verdict.reason
    first, second = arm.goals("MoveGroup")[-2:]
    assert first["request"]["goal_constraints"][0]["position_constraints"][0]["header"]["frame_id"] == "base"
    assert [goal["planning_options"]["replan"] for goal in (first, second)] == [True, False]


async def test_without_a_planner_the_controller_receives_a_timed_trajectory(arm: BridgedArm) -> None:
    end = Ends()
    async with connect_robots(arm.endpoint, "a test") as node:
        await node.move_joints("plain", (0.4, 0.2), ("shoulder_pan_joint", "elbow_joint"), MANNER, end)
        assert (await end.wait()).status is GoalStatus.SUCCEEDED
        with pytest.raises(BackendRefused, match="does not support 'move_to_pose'"):
            await node.move_tool("plain", Pose3D(), "base_link", MANNER, end, straight=False)
        with pytest.raises(BackendRefused, match="the robot has no planner"):
            await node.move_joints("plain", (0.0, 0.0), (), MotionOptions(0.5, 0.01, (), True), end)
    trajectory = arm.goals("FollowJointTrajectory")[0]["trajectory"]
    assert trajectory["joint_names"] == ["shoulder_pan_joint", "elbow_joint"]
    assert trajectory["points"][0]["velocities"] == [0.0, 0.0]


async def test_grippers_reach_an_opening_or_stop_at_an_object(arm: BridgedArm) -> None:
    async with connect_robots(arm.endpoint, "a test") as node:
        for opening, message in ((0.05, ""), (0.0, "an object stopped the fingers at 0.030 m")):
            end = Ends()
            await node.move_gripper("planned", opening, 30.0, MANNER, end)
            report = await end.wait()
            assert (report.status, report.message) == (GoalStatus.SUCCEEDED, message)
            state = await node.arm_state("planned")
            assert state.held == ("something" if message else "")
            assert (state.tool.position.x, state.tool.position.z) == (0.5, 0.4)
        with pytest.raises(BackendRefused, match=r"expected an opening of 0 to 0\.085 m"):
            await node.move_gripper("planned", 0.2, None, MANNER, Ends())
        numb = Ends()
        await node.move_gripper("planned", 0.0, NUMB, MANNER, numb)
        report = await numb.wait()
        assert report.status is GoalStatus.ABORTED
        assert "the gripper has sent no valid opening" in report.message
        assert (await node.arm_state("planned")).held == ""
    command = arm.goals("GripperCommand")[0]["command"]
    assert command["position"] == pytest.approx(0.8 - 0.05 * 0.8 / 0.085)
    assert command["max_effort"] == 30.0


async def test_unsupported_motions_of_an_arm_are_refused(arm: BridgedArm) -> None:
    async with connect_robots(arm.endpoint, "a test") as node:
        with pytest.raises(BackendRefused, match="`may_touch`"):
            await node.move_joints("planned", ALL, (), MotionOptions(0.5, 0.01, ("box",), False), Ends())
        with pytest.raises(BackendRefused, match="expected positions of 6 joints, got 2"):
            await node.move_joints("planned", (0.0, 0.0), (), MANNER, Ends())
        with pytest.raises(BackendRefused, match="unknown joints knee"):
            await node.move_joints("planned", (0.0,), ("knee",), MANNER, Ends())
        with pytest.raises(BackendRefused, match="invalid speed factor 2"):
            await node.move_joints("planned", ALL, (), MotionOptions(2.0, 0.01, (), False), Ends())
