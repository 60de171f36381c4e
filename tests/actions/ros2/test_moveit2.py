"""Actions of `osc.moveit2` in a ROS 2 system, with servers by the published definitions of MoveIt."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.action_server import Status
from seoro.bridges.ros2.wire import LATCHED
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import expect_failure, ran_of, running
from tests.actions.ros2.definitions_server import Offer, Servers, serving
from tests.runtime.conftest import Ran
from tests.tools.ros_definitions import definitions

DONE = {"error_code": {"val": 1}}
SRDF = """<robot name="a"><group_state name="home" group="arm"><joint name="j1" value="0.5"/>
<joint name="j2" value="-1"/></group_state><group_state name="open" group="hand"/></robot>"""
ROBOT = """
import osc.moveit2
import osc.manipulation
scenario main:
    robot: manipulator with:
        keep(it.namespace == 'cell')
        keep(it.arm_joints == ['j1', 'j2'])
        keep(it.gripper_joints == ['f1'])
    do serial:
"""
LIMIT = 120.0  # [s] of a run of a second


def planner(answer: Mapping[str, Any] = DONE, status: Status = Status.SUCCEEDED) -> Offer:
    return Offer("/cell/move_action", "moveit_msgs/action/MoveGroup", answer, status)


def executor() -> Offer:
    return Offer("/cell/execute_trajectory", "moveit_msgs/action/ExecuteTrajectory", DONE)


def service(name: str, kind: str, answer: Mapping[str, Any]) -> Offer:
    return Offer(f"/cell/{name}", f"moveit_msgs/srv/{kind}", answer)


async def run(folder: Path, router: str, lines: str, *offers: Offer, srdf: str = SRDF) -> tuple[Ran, Servers]:
    """Run invocations of an arm on servers."""
    text = ROBOT + "".join(f"        {line.strip()}\n" for line in lines.strip().splitlines())
    with anyio.fail_after(LIMIT):
        async with (
            serving(router, definitions("jazzy"), offers) as servers,
            servers.node.publishing("/cell/robot_description_semantic", "std_msgs/msg/String", LATCHED) as texts,
        ):
            texts.publish({"data": srdf})
            async with running(folder, router, text) as started:
                return await ran_of(started), servers


async def test_arms_are_moved_by_move_group(tmp_path: Path, router: str) -> None:
    lines = """
        robot.move_to_joint_pose([0.1, 0.2], move_group_type!arm, max_velocity_scaling_factor: 0.5)
        robot.move_to_joint_pose([0.02], move_group_type!gripper, plan_only: true)
        robot.move_to_pose(pose_3d(position_3d(x: 40cm)), tolerance: 0.01)
        robot.move_to_named_pose('home')
    """
    ran, servers = await run(tmp_path, router, lines, planner())
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    goals = [goal for _, goal in servers.seen]
    requests = [goal["request"] for goal in goals]
    assert [each["group_name"] for each in requests] == ["arm", "gripper", "arm", "arm"]
    assert requests[0]["max_velocity_scaling_factor"] == 0.5
    assert [goal["planning_options"]["plan_only"] for goal in goals] == [False, True, False, False]
    joints = [
        {joint["joint_name"]: joint["position"] for joint in request["goal_constraints"][0]["joint_constraints"]}
        for request in requests
    ]
    assert joints == [{"j1": 0.1, "j2": 0.2}, {"f1": 0.02}, {}, {"j1": 0.5, "j2": -1.0}]
    [place] = requests[2]["goal_constraints"][0]["position_constraints"]
    assert (place["link_name"], place["header"]["frame_id"]) == ("tcp", "base_link")
    assert place["constraint_region"]["primitive_poses"][0]["position"]["x"] == 0.4


async def test_the_planning_scene_is_changed_and_read(tmp_path: Path, router: str) -> None:
    scene = {
        "world": {"collision_objects": [{"id": "table"}]},
        "robot_state": {"attached_collision_objects": [{"object": {"id": "cup"}}]},
    }
    lines = """
        robot.add_collision_object('table', collision_shape!box, [1m, 50cm, 2cm], pose_3d(position_3d(z: -2cm)))
        robot.attach_object('cup', touch_links: ['finger'])
        robot.check_collision_object('table')
        robot.check_collision_object('cup', attached: true)
        robot.detach_object('cup')
        robot.remove_collision_object('cup')
    """
    ran, servers = await run(
        tmp_path,
        router,
        lines,
        service("apply_planning_scene", "ApplyPlanningScene", {"success": True}),
        service("get_planning_scene", "GetPlanningScene", {"scene": scene}),
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    scenes = [request["scene"] for name, request in servers.seen if name.endswith("apply_planning_scene")]
    assert all(each["is_diff"] and each["robot_state"]["is_diff"] for each in scenes)
    [table], [attached], [detached], [removed] = (
        each["world"]["collision_objects"] or each["robot_state"]["attached_collision_objects"] for each in scenes
    )
    assert (table["id"], table["header"]["frame_id"], table["operation"]) == ("table", "base_link", 0)
    assert list(table["primitives"][0]["dimensions"]) == [1.0, 0.5, 0.02]
    assert (attached["link_name"], attached["touch_links"]) == ("tcp", ["tcp", "finger"])
    assert (detached["object"]["id"], detached["object"]["operation"]) == ("cup", 1)
    assert (removed["id"], removed["operation"]) == ("cup", 1)


async def test_tools_follow_straight_lines(tmp_path: Path, router: str) -> None:
    solution = {"joint_trajectory": {"joint_names": ["j1"], "points": [{"positions": [0.3]}]}}
    lines = "robot.move_along_poses([pose_3d(position_3d(x: 40cm)), pose_3d(position_3d(x: 50cm))])"
    path = {**DONE, "solution": solution, "fraction": 1.0}
    ran, servers = await run(
        tmp_path, router, lines, service("compute_cartesian_path", "GetCartesianPath", path), executor()
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    asked = servers.of("/cell/compute_cartesian_path")
    assert (asked["max_step"], len(asked["waypoints"]), asked["link_name"]) == (0.01, 2, "tcp")
    sent = servers.of("/cell/execute_trajectory")["trajectory"]["joint_trajectory"]
    assert (sent["joint_names"], list(sent["points"][0]["positions"])) == (["j1"], [0.3])
    half = service("compute_cartesian_path", "GetCartesianPath", {**path, "fraction": 0.5})
    ran, servers = await run(tmp_path, router, lines, half, executor())
    expect_failure(ran.verdict, "only 50% of the path can be followed; expected at least 100%")
    assert len(servers.seen) == 1


@pytest.mark.parametrize(
    ("invocation", "offer", "reason"),
    [
        (
            "robot.move_to_pose(pose_3d())",
            planner({"error_code": {"val": -31, "message": "no solver"}}, Status.ABORTED),
            "the goal of /cell/move_action was aborted: MoveIt: the pose is out of.*NO_IK_SOLUTION, error -31",
        ),
        ("robot.move_to_pose(pose_3d())", planner({"error_code": {"val": -4}}), "CONTROL_FAILED, error -4"),
        (
            "robot.move_to_joint_pose([0.1], move_group_type!arm)",
            planner(),
            "expected a position for each of `arm_joints` of `robot`: j1, j2; found 1 positions",
        ),
        ("robot.move_to_named_pose('up')", planner(), r"unknown state 'up' of the group 'arm'.*\(states: home\)"),
        (
            "robot.add_collision_object('a', collision_shape!sphere, [1m, 2m], pose_3d())",
            planner(),
            "invalid `dimensions` of a sphere: expected 1 lengths above 0",
        ),
        (
            "robot.detach_object('a')",
            service("apply_planning_scene", "ApplyPlanningScene", {"success": False}),
            "MoveIt rejects the change of the planning scene",
        ),
        (
            "robot.check_collision_object('a')",
            service("get_planning_scene", "GetPlanningScene", {}),
            r"no object 'a' in the planning scene \(in the scene: none; attached: none\)",
        ),
    ],
)
async def test_failures_have_reasons(
    invocation: str, offer: Offer, reason: str, tmp_path: Path, router: str
) -> None:
    ran, _ = await run(tmp_path, router, invocation, offer)
    expect_failure(ran.verdict, reason)


@pytest.mark.parametrize("srdf", ["<robot", '<!DOCTYPE a [<!ENTITY b "c">]><robot>&b;</robot>'])
async def test_an_invalid_srdf_is_refused(srdf: str, tmp_path: Path, router: str) -> None:
    ran, _ = await run(tmp_path, router, "robot.move_to_named_pose('home')", planner(), srdf=srdf)
    expect_failure(ran.verdict, "invalid SRDF on /cell/robot_description_semantic")
