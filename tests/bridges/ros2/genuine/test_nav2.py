"""Actions of `osc.nav2` on genuine action servers with the types of Nav2, and clients of an own server."""

from __future__ import annotations

from pathlib import Path

import anyio
import pytest

from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from tests.actions.ros2.conftest import expect_failure, ran_of, running
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2
from tests.bridges.ros2.genuine.steering import own_node, steered
from tests.runtime.conftest import Ran
from tests.tools.ros_definitions import definitions

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

NAVIGATE = "nav2_msgs/action/NavigateToPose"
FOLLOW = "nav2_msgs/action/FollowWaypoints"
POSE = "pose_3d(position_3d(x: 1m, y: 2m), orientation_3d(yaw: 180deg))"


async def run(folder: Path, router: str, invocation: str) -> Ran:
    text = f"import osc.nav2\nscenario main:\n    robot: differential_drive_robot\n    do robot.{invocation}\n"
    with anyio.fail_after(DEADLINE):
        async with running(folder, router, text) as started:
            return await ran_of(started)


async def test_robots_navigate_by_genuine_servers(ros2: Ros2, router: str, tmp_path: Path) -> None:
    async with steered(ros2, router) as genuine:
        feedback = [{"distance_remaining": 1.5, "number_of_recoveries": 1}]
        await genuine.ask("act", action="/navigate_to_pose", type=NAVIGATE, feedback=feedback, lasts=0.3)
        ran = await run(tmp_path, router, f"nav_to_pose({POSE})")
        assert ran.verdict.reason == ""
        goal = (await genuine.event("goal"))["goal"]["pose"]
        assert (goal["header"]["frame_id"], goal["pose"]["position"]["y"]) == ("map", 2.0)
        assert goal["pose"]["orientation"]["z"] == pytest.approx(1.0)
        result = {"missed_waypoints": [{"waypoint_index": 1}], "error_code": 601, "error_msg": "no picture"}
        await genuine.ask("act", action="/follow_waypoints", type=FOLLOW, order="abort", result=result)
        ran = await run(tmp_path, router, f"follow_waypoints([{POSE}, {POSE}])")
        expect_failure(ran.verdict, "missed waypoints: 2; the task at a waypoint failed.*error 601.*no picture")
        assert len((await genuine.event("goal"))["goal"]["poses"]) == 2


async def test_an_aborted_navigation_has_a_reason(ros2: Ros2, router: str, tmp_path: Path) -> None:
    async with steered(ros2, router) as genuine:
        result = {"error_code": 208, "error_msg": "GridBased found none"}
        await genuine.ask("act", action="/navigate_to_pose", type=NAVIGATE, order="abort", result=result)
        ran = await run(tmp_path, router, f"nav_to_pose({POSE})")
        expect_failure(ran.verdict, "no path leads to the goal.*NO_VALID_PATH, error 208.*GridBased found none")


async def test_a_timeout_cancels_the_goal(ros2: Ros2, router: str, tmp_path: Path) -> None:
    async with steered(ros2, router) as genuine:
        await genuine.ask("act", action="/navigate_to_pose", type=NAVIGATE, lasts=600.0)
        ran = await run(tmp_path, router, f"nav_to_pose({POSE}) with:\n        timeout(3s)")
        expect_failure(ran.verdict, "timeout")
        await genuine.event("canceled")


async def test_genuine_clients_navigate_an_own_robot(ros2: Ros2, router: str) -> None:
    goals: list[float] = []

    async def execute(goal: GoalHandle) -> GoalEnd:
        goals.append(goal.goal.pose.pose.position.x)
        return GoalEnd(Status.ABORTED, {"error_code": 204, "error_msg": "outside"})

    async with (
        steered(ros2, router) as genuine,
        own_node(router, definitions("kilted")) as own,
        serving_action(own, "/navigate_to_pose", NAVIGATE, execute),
    ):
        goal = {"pose": {"pose": {"position": {"x": 4.0}}}}
        await genuine.ask("send_goal", action="/navigate_to_pose", type=NAVIGATE, goal=goal, name="far")
        end = await genuine.event("result", goal="far")
    assert (end["status"], end["result"]["error_code"], goals) == (Status.ABORTED, 204, [4.0])
