"""A robot of ROS 2 that drives, behind the bridge."""

from __future__ import annotations

import time
from pathlib import Path

import anyio
import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.errors import BackendRefused
from seoro.runtime.contracts import (
    GoalStatus,
    OrientationRate3D,
    Pose3D,
    Position3D,
    TranslationalVelocity3D,
    Velocity6D,
)
from seoro.runtime.verdict import RunStatus
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.robots.conftest import Bridged, run_on_robot

pytestmark = pytest.mark.anyio


def at(x: float, y: float = 0.0) -> Pose3D:
    return Pose3D(Position3D(x=x, y=y))


async def test_a_robot_is_localised_drives_to_poses_and_tells_of_it(bridged: Bridged) -> None:
    happened: list[tuple[str, object]] = []
    end, near, far, localised = Ends(), Ends(), Ends(), Ends()
    async with connect_robots(bridged.endpoint, "a test") as node:
        await node.start_run(lambda name, arguments: happened.append((name, arguments)), print)
        await node.watch_localization("tb", localised)
        await node.set_initial_pose("tb", at(5.0))
        assert (await localised.wait()).status is GoalStatus.SUCCEEDED
        assert bridged.notes("told")[0][1] == 5.0
        await node.watch_proximity("tb", "base_link", "map", Position3D(x=5.3), 0.05, near)
        await node.watch_distance("tb", 0.5, far)
        await node.navigate("tb", [at(0.6)], stop_at_each=False, report=end)
        for each in (near, far, end):
            assert (await each.wait()).status is GoalStatus.SUCCEEDED
        with anyio.fail_after(2.0):
            while not happened:
                await anyio.sleep(0.02)
    name, arguments = happened[0]
    assert name == "navigation_feedback"
    assert isinstance(arguments, dict)
    assert (arguments["robot"], arguments["number_of_recoveries"]) == ("tb", 2)


NAV2 = "import osc.nav2\nscenario main:\n    tb: differential_drive_robot\n    do serial:\n"


async def test_where_a_robot_is_may_be_told_by_others(bridged: Bridged, tmp_path: Path) -> None:
    waiting = "        tb.init_nav2(pose_3d(), use_initial_pose: false, wait_for_initial_pose: true)\n"
    async with connect_robots(bridged.endpoint, "a test") as node:
        await node.set_initial_pose("tb", at(1.0))
    verdict = await run_on_robot(tmp_path, NAV2 + waiting, bridged.endpoint, "tb", "tb")
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert len(bridged.notes("told")) == 1


async def test_a_goal_that_nobody_waits_for_gives_way_to_the_next_and_ends_with_the_run(
    bridged: Bridged, tmp_path: Path
) -> None:
    goals = "        tb.nav_to_pose(pose_3d(position_3d(x: {x}m)), success_on_acceptance: {left})\n"
    text = NAV2 + "".join(goals.format(x=x, left=left) for x, left in ((50, "true"), (0.1, "false"), (60, "true")))
    verdict = await run_on_robot(tmp_path, text, bridged.endpoint, "tb", "tb")
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert [value for _, value in bridged.notes("goal")] == [1.0, -5.0, 1.0, -4.0, 1.0, -5.0]


async def test_names_that_the_bridge_knows_are_refused_in_scenarios(bridged: Bridged, tmp_path: Path) -> None:
    named = "        tb.nav_to_pose(pose_3d(), action_topic: 'go_there')\n"
    verdict = await run_on_robot(tmp_path, NAV2 + named, bridged.endpoint, "tb", "tb")
    assert "`action_topic` cannot be chosen here; leave it out" in verdict.reason


@pytest.mark.parametrize("stop_at_each", [False, True])
async def test_poses_are_driven_through_or_stopped_at(bridged: Bridged, stop_at_each: bool) -> None:
    end = Ends()
    async with connect_robots(bridged.endpoint, "a test") as node:
        await node.navigate("tb", [at(0.1), at(0.2)], stop_at_each=stop_at_each, report=end)
        assert (await end.wait()).status is GoalStatus.SUCCEEDED
    assert [value for _, value in bridged.notes("goal")] == [2.0, -4.0]


async def test_goals_that_come_to_nothing_say_why(bridged: Bridged) -> None:
    end = Ends()
    async with connect_robots(bridged.endpoint, "a test") as node:
        with pytest.raises(BackendRefused, match="rejects the goal"):
            await node.navigate("tb", [at(13.0)], stop_at_each=False, report=end)
        await node.navigate("tb", [at(66.0)], stop_at_each=False, report=end)
        report = await end.wait()
        assert report.status is GoalStatus.ABORTED
        assert "the robot has aborted the goal" in report.message
        with pytest.raises(BackendRefused, match="no frame no_link: the robot 'tb' has base_link, "):
            await node.watch_proximity("tb", "no_link", "odom", Position3D(), 1.0, end)


async def test_a_goal_that_is_called_off_is_canceled_on_the_robot(bridged: Bridged) -> None:
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
async def test_velocities_are_taken_in_either_form_and_end_with_zero(bridged: Bridged) -> None:
    end = Ends()
    async with connect_robots(bridged.endpoint, "a test") as node:
        began = time.monotonic()
        await node.drive(bridged.name, 0.2, 0.0, 0.3, end)
        assert (await end.wait()).status is GoalStatus.SUCCEEDED
        assert 0.3 <= time.monotonic() - began < 0.6
    velocities = [value for _, value in bridged.notes("velocity")]
    assert velocities[-1] == 0.0
    assert set(velocities) == {0.0, 0.2}


async def test_velocities_beyond_the_limits_are_refused(bridged: Bridged) -> None:
    async with connect_robots(bridged.endpoint, "a test") as node:
        with pytest.raises(BackendRefused, match=r"beyond the limits of the robot's profile, 0\.306 m/s"):
            await node.drive("tb", 0.4, 0.0, 1.0, Ends())
        with pytest.raises(BackendRefused, match="no finite number"):
            await node.drive("tb", float("nan"), 0.0, 1.0, Ends())
        assert not any(value for _, value in bridged.notes("velocity"))


@pytest.mark.parametrize("how", ["drives", "navigates"])
async def test_a_single_command_of_velocity_is_refused_beside_a_goal(bridged: Bridged, how: str) -> None:
    ahead = Velocity6D(TranslationalVelocity3D(x=0.1), OrientationRate3D())
    async with connect_robots(bridged.endpoint, "a test") as node:
        if how == "drives":
            await node.drive("tb", 0.2, 0.0, 60.0, Ends())
        else:
            await node.navigate("tb", [at(50.0)], stop_at_each=False, report=Ends())
        with pytest.raises(BackendRefused, match=r"tb is driving to goal '.+': cancel it, or wait for its end"):
            await node.command_velocity("/tb/cmd_vel", ahead)
    assert 0.1 not in [value for _, value in bridged.notes("velocity")]


async def test_a_single_command_of_velocity_ends_by_itself(bridged: Bridged) -> None:
    ahead = Velocity6D(TranslationalVelocity3D(x=0.1), OrientationRate3D())
    async with connect_robots(bridged.endpoint, "a test") as node:
        began = time.monotonic()
        await node.command_velocity("/tb/cmd_vel", ahead)
        await anyio.sleep(0.7)
        stopped = bridged.stopped()
        assert stopped is not None
        assert 0.4 < stopped - began < 0.65
