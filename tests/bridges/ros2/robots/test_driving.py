"""A driving ROS 2 robot behind the bridge."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import anyio
import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.errors import BackendRefused
from seoro.robotics.geometry import (
    OrientationRate3D,
    Pose3D,
    Position3D,
    TranslationalVelocity3D,
    Velocity6D,
)
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.verdict import RunStatus
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.robots.conftest import Bridged, run_on_robot
from tests.stopwatch import attempts

pytestmark = pytest.mark.anyio


def at(x: float, y: float = 0.0) -> Pose3D:
    return Pose3D(Position3D(x=x, y=y))


async def test_a_localised_robot_drives_to_poses_and_reports_feedback(bridged: Bridged) -> None:
    happened: list[tuple[str, object]] = []
    end, near, far, localised = Ends(), Ends(), Ends(), Ends()
    async with connect_robots(bridged.endpoint, "a test") as node:
        await node.start_run(lambda name, arguments: happened.append((name, arguments)), print)
        await node.watch_localization("tb", localised)
        await node.set_initial_pose("tb", at(5.0))
        assert (await localised.wait()).status is GoalStatus.SUCCEEDED
        assert bridged.notes("initial_pose")[0][1] == 5.0
        await node.watch_proximity("tb", "base_link", "map", Position3D(x=5.3), 0.05, near)
        await node.watch_distance("tb", 0.5, far)
        await node.navigate("tb", [at(0.6)], stop_at_each=False, report=end)
        for each in (near, far, end):
            assert (await each.wait()).status is GoalStatus.SUCCEEDED
        with anyio.fail_after(30.0):
            while not happened:
                await anyio.sleep(0.02)
    name, arguments = happened[0]
    assert name == "navigation_feedback"
    assert isinstance(arguments, dict)
    assert (arguments["robot"], arguments["number_of_recoveries"]) == ("tb", 2)


NAV2 = "import osc.nav2\nscenario main:\n    tb: differential_drive_robot\n    do serial:\n"


async def test_the_initial_pose_may_come_from_other_nodes(bridged: Bridged, tmp_path: Path) -> None:
    waiting = "        tb.init_nav2(pose_3d(), use_initial_pose: false, wait_for_initial_pose: true)\n"
    async with connect_robots(bridged.endpoint, "a test") as node:
        await node.set_initial_pose("tb", at(1.0))
    verdict = await run_on_robot(tmp_path, NAV2 + waiting, bridged.endpoint, "tb", "tb")
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert len(bridged.notes("initial_pose")) == 1


async def test_a_goal_without_a_waiting_action_is_replaced_or_ends_with_the_run(
    bridged: Bridged, tmp_path: Path
) -> None:
    goals = "        tb.nav_to_pose(pose_3d(position_3d(x: {x}m)), success_on_acceptance: {left})\n"
    text = NAV2 + "".join(goals.format(x=x, left=left) for x, left in ((50, "true"), (0.1, "false"), (60, "true")))
    verdict = await run_on_robot(tmp_path, text, bridged.endpoint, "tb", "tb")
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert [value for _, value in bridged.notes("goal")] == [1.0, -5.0, 1.0, -4.0, 1.0, -5.0]


async def test_names_of_the_profile_are_refused_in_scenarios(bridged: Bridged, tmp_path: Path) -> None:
    named = "        tb.nav_to_pose(pose_3d(), action_topic: 'go_there')\n"
    verdict = await run_on_robot(tmp_path, NAV2 + named, bridged.endpoint, "tb", "tb")
    assert "`action_topic` cannot be set in a scenario; omit it" in verdict.reason


@pytest.mark.parametrize("stop_at_each", [False, True])
async def test_robots_drive_through_poses_or_stop_at_each(bridged: Bridged, stop_at_each: bool) -> None:
    end = Ends()
    async with connect_robots(bridged.endpoint, "a test") as node:
        await node.navigate("tb", [at(0.1), at(0.2)], stop_at_each=stop_at_each, report=end)
        assert (await end.wait()).status is GoalStatus.SUCCEEDED
    assert [value for _, value in bridged.notes("goal")] == [2.0, -4.0]


async def test_failed_goals_have_a_reason(bridged: Bridged) -> None:
    end = Ends()
    async with connect_robots(bridged.endpoint, "a test") as node:
        with pytest.raises(BackendRefused, match="rejects the goal"):
            await node.navigate("tb", [at(13.0)], stop_at_each=False, report=end)
        await node.navigate("tb", [at(66.0)], stop_at_each=False, report=end)
        report = await end.wait()
        assert report.status is GoalStatus.ABORTED
        assert "the robot has aborted the goal" in report.message
        with pytest.raises(BackendRefused, match=r"unknown frame no_link \(frames of 'tb': base_link, "):
            await node.watch_proximity("tb", "no_link", "odom", Position3D(), 1.0, end)


async def test_a_cancelled_goal_is_canceled_on_the_robot(bridged: Bridged) -> None:
    async with connect_robots(bridged.endpoint, "a test") as node:
        goal = await node.navigate("tb", [at(50.0)], stop_at_each=False, report=Ends())
        await node.cancel_goal(goal)
        assert [value for _, value in bridged.notes("goal")] == [1.0, -5.0]


async def test_robots_stand_still_and_have_no_goal_after_a_run(bridged: Bridged) -> None:
    async with connect_robots(bridged.endpoint, "a test") as node:
        await node.navigate("tb", [at(50.0)], stop_at_each=False, report=Ends())
    assert [value for _, value in bridged.notes("goal")] == [1.0, -5.0]
    assert bridged.notes("velocity")[-1][1] == 0.0


@pytest.mark.parametrize("bridged", ["tb", "stamped"], indirect=True)
async def test_velocities_of_either_message_type_end_with_zero(bridged: Bridged) -> None:
    times: list[float] = []
    async with connect_robots(bridged.endpoint, "a test") as node:
        for _ in attempts(times, 0.6):
            end, began = Ends(), time.monotonic()
            await node.drive(bridged.name, 0.2, 0.0, 0.3, end)
            assert (await end.wait()).status is GoalStatus.SUCCEEDED
            times.append(time.monotonic() - began)
    assert 0.3 <= min(times) < 0.6
    velocities = [value for _, value in bridged.notes("velocity")]
    assert velocities[-1] == 0.0
    assert set(velocities) == {0.0, 0.2}


async def test_velocities_beyond_the_limits_are_refused(bridged: Bridged) -> None:
    async with connect_robots(bridged.endpoint, "a test") as node:
        with pytest.raises(BackendRefused, match=r"beyond the limits of the robot's profile, 0\.306 m/s"):
            await node.drive("tb", 0.4, 0.0, 1.0, Ends())
        with pytest.raises(BackendRefused, match="finite number"):
            await node.drive("tb", float("nan"), 0.0, 1.0, Ends())
        assert not any(value for _, value in bridged.notes("velocity"))


@pytest.mark.parametrize("how", ["drives", "navigates"])
async def test_a_single_velocity_command_is_refused_during_a_goal(bridged: Bridged, how: str) -> None:
    ahead = Velocity6D(TranslationalVelocity3D(x=0.1), OrientationRate3D())
    async with connect_robots(bridged.endpoint, "a test") as node:
        if how == "drives":
            await node.drive("tb", 0.2, 0.0, 60.0, Ends())
        else:
            await node.navigate("tb", [at(50.0)], stop_at_each=False, report=Ends())
        with pytest.raises(BackendRefused, match=r"tb is driving to goal '.+': cancel it, or wait for its end"):
            await node.command_velocity("/tb/cmd_vel", ahead)
    assert 0.1 not in [value for _, value in bridged.notes("velocity")]


async def test_a_single_velocity_command_expires(bridged: Bridged) -> None:
    ahead = Velocity6D(TranslationalVelocity3D(x=0.1), OrientationRate3D())
    times: list[float] = []
    async with connect_robots(bridged.endpoint, "a test") as node:
        for _ in attempts(times, 0.65):
            began = time.monotonic()
            await node.command_velocity("/tb/cmd_vel", ahead)
            robot = replace(bridged, since=began)
            with anyio.fail_after(30.0):
                while (stopped := robot.stopped()) is None:
                    await anyio.sleep(0.02)
            times.append(stopped - began)
    assert 0.4 < min(times) < 0.65
