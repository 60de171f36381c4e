"""Robots that fail, and robots behind a bridge for DDS."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import anyio
import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import GoalStatus
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.robots.conftest import BRIDGE, FAKE_ROBOT, Bridged
from tests.routers import as_if_elsewhere, free_endpoint, process, router_process

pytestmark = [pytest.mark.anyio, pytest.mark.more]

ALIKE = "geometry_msgs/msg/Twist"


@contextmanager
def alone(folder: Path, dialect: str = "rmw_zenoh") -> Iterator[tuple[Bridged, subprocess.Popen[bytes]]]:
    """Yield a robot `tb` behind a bridge, for one test that may kill it."""
    router, endpoint = free_endpoint(), f"unixsock-stream/{folder}/bridge"
    with (
        router_process(router),
        process(str(FAKE_ROBOT), str(folder), router, "tb", ALIKE, dialect) as robot,
        process("-c", BRIDGE, router, endpoint, "tb"),
    ):
        yield Bridged(endpoint, folder / "tb"), robot


def at(x: float) -> Pose3D:
    return Pose3D(Position3D(x=x))


async def test_the_goal_of_a_robot_that_dies_is_aborted(tmp_path: Path) -> None:
    end = Ends()
    with alone(tmp_path) as (bridged, robot):
        async with connect_robots(bridged.endpoint, "a test") as node:
            await node.navigate("tb", [at(50.0)], stop_at_each=False, report=end)
            robot.kill()
            report = await end.wait()
            assert report.status is GoalStatus.ABORTED
            assert "navigate_to_pose" in report.message
            with pytest.raises(BackendRefused, match="no server of the action /tb/navigate_to_pose"):
                await node.navigate("tb", [at(1.0)], stop_at_each=False, report=end)


async def test_a_robot_that_never_answers_times_out(tmp_path: Path) -> None:
    with alone(tmp_path) as (bridged, _):
        async with connect_robots(bridged.endpoint, "a test") as node:
            began = time.monotonic()
            with pytest.raises(BackendRefused, match="send_goal"):
                await node.navigate("tb", [at(99.0)], stop_at_each=False, report=Ends())
            assert time.monotonic() - began < 40.0


async def test_robots_behind_a_bridge_for_dds_are_driven(tmp_path: Path) -> None:
    end, near = Ends(), Ends()
    with alone(tmp_path, "ros2dds") as (bridged, _):
        async with connect_robots(bridged.endpoint, "a test") as node:
            await node.set_initial_pose("tb", at(5.0))
            await node.watch_proximity("tb", "base_link", "map", Position3D(x=5.3), 0.05, near)
            await node.navigate("tb", [at(0.6)], stop_at_each=False, report=end)
            for each in (near, end):
                assert (await each.wait()).status is GoalStatus.SUCCEEDED
            goal = await node.navigate("tb", [at(50.0)], stop_at_each=False, report=Ends())
            await node.cancel_goal(goal)
        with anyio.fail_after(30.0):
            while bridged.notes("goal")[-1][1] != -5.0:
                await anyio.sleep(0.02)


async def test_a_robot_is_reachable_after_a_restart_of_its_router(tmp_path: Path) -> None:
    router, endpoint = free_endpoint(), f"unixsock-stream/{tmp_path}/bridge"
    end, again, driven = Ends(), Ends(), Ends()
    with (
        router_process(router) as first,
        process(str(FAKE_ROBOT), str(tmp_path), as_if_elsewhere(router), "tb", ALIKE),
        process("-c", BRIDGE, as_if_elsewhere(router), endpoint, "tb"),
    ):
        async with connect_robots(endpoint, "a test") as node:
            await node.navigate("tb", [at(50.0)], stop_at_each=False, report=end)
            first.kill()
            first.wait()
            ended = await end.wait()
            assert ended.status is GoalStatus.ABORTED
            assert ended.interrupted
            assert [value for _, value in Bridged(endpoint, tmp_path / "tb", since=0.0).notes("goal")] == [1.0]
            with router_process(router):
                with anyio.fail_after(30.0):
                    while Bridged(endpoint, tmp_path / "tb", since=0.0).notes("goal")[-1][1] != -5.0:
                        await anyio.sleep(0.02)
                await node.drive("tb", 0.1, 0.0, 0.2, driven)
                assert (await driven.wait()).status is GoalStatus.SUCCEEDED
                await node.navigate("tb", [at(0.1)], stop_at_each=False, report=again)
                assert (await again.wait()).status is GoalStatus.SUCCEEDED


async def test_a_restarted_robot_has_its_new_pose_and_drives(tmp_path: Path) -> None:
    router, endpoint = free_endpoint(), f"unixsock-stream/{tmp_path}/bridge"
    fake = [str(FAKE_ROBOT), str(tmp_path), router, "tb", ALIKE]
    driven, far, arrived = Ends(), Ends(), Ends()
    with router_process(router), process(*fake) as robot, process("-c", BRIDGE, router, endpoint, "tb"):
        async with connect_robots(endpoint, "a test") as node:
            await node.navigate("tb", [at(1.0)], stop_at_each=False, report=far)
            assert (await far.wait()).status is GoalStatus.SUCCEEDED
            robot.kill()
            robot.wait()
            with anyio.fail_after(30.0):
                with pytest.raises(BackendRefused, match="unknown frame base_link, odom"):
                    while True:  # until the bridge has noticed
                        watch = await node.watch_proximity(
                            "tb", "base_link", "odom", Position3D(x=9.0), 0.1, Ends()
                        )
                        await node.cancel_watch(watch)
        with process(*fake):
            async with connect_robots(endpoint, "a test") as node:
                await node.watch_proximity("tb", "base_link", "odom", Position3D(), 0.1, arrived)
                assert (await arrived.wait()).status is GoalStatus.SUCCEEDED
                await node.drive("tb", 0.1, 0.0, 0.2, driven)
                assert (await driven.wait()).status is GoalStatus.SUCCEEDED


async def test_a_clock_that_jumps_back_is_logged_and_drops_earlier_transforms(tmp_path: Path) -> None:
    router, endpoint = free_endpoint(), f"unixsock-stream/{tmp_path}/bridge"
    transform = {"header": {"frame_id": "odom", "stamp": {"sec": 90}}, "child_frame_id": "base_link"}
    placed = {"transforms": [{**transform, "transform": {"rotation": {"w": 1.0}}}]}
    with (tmp_path / "message").open("wb") as message, router_process(router):
        async with (
            connect(router, dialect=RmwZenoh()) as system,
            system.node("simulator", "/tb") as simulator,
            simulator.publishing("/clock", "rosgraph_msgs/msg/Clock") as clock,
            simulator.publishing("tf", "tf2_msgs/msg/TFMessage") as frames,
        ):
            with process("-c", BRIDGE, router, endpoint, "tb", stderr=message):
                async with connect_robots(endpoint, "a test") as node:
                    for publication in (clock, frames):
                        await publication.wait_for_subscription(10.0)
                    clock.publish({"clock": {"sec": 90}})
                    frames.publish(placed)
                    await node.watch_proximity("tb", "base_link", "odom", Position3D(x=9.0), 0.1, Ends())
                    clock.publish({"clock": {"sec": 89, "nanosec": 500_000_000}})
                    await anyio.sleep(0.3)
                    with pytest.raises(BackendRefused, match="unknown frame base_link, odom"):
                        await node.watch_proximity("tb", "base_link", "odom", Position3D(x=9.0), 0.1, Ends())
    assert "/clock jumped back from 90.000 s to 89.500 s" in (tmp_path / "message").read_text()


STOPPED = "the robot 'tb' was stopped"
OTHER = "@ros2_lv/0/aa/1/2/MP/%/%tb/robot/%tb%odom/std_msgs::msg::dds_::String_/RIHS01_12/1:2:1,10:,:,:,,"


async def test_the_reason_of_a_silent_topic_is_reported(tmp_path: Path) -> None:
    router, endpoint = free_endpoint(), f"unixsock-stream/{tmp_path}/bridge"

    async def why() -> str:
        message = STOPPED
        while message == STOPPED:  # a busy machine may keep this process from a heartbeat
            with pytest.raises(BackendRefused) as refused:
                await node.watch_distance("tb", 1.0, Ends())
            message = str(refused.value)
        return message.removeprefix("no odometry of the robot on /tb/odom: ")

    with router_process(router):
        async with connect(router, dialect=RmwZenoh()) as system, system.node("robot", "/tb") as robot:
            with process("-c", BRIDGE, router, endpoint, "tb"):
                async with connect_robots(endpoint, "a test") as node:
                    assert await why() == "no publisher"
                    async with robot.publishing("odom", "nav_msgs/msg/Odometry") as odometry:
                        await odometry.wait_for_subscription(30.0)
                        odometry.send(b"\0\1\0\0x")
                        assert (await why()).startswith("invalid message on /tb/odom: nav_msgs/msg/Odom")
                    async with system.session.token(OTHER):
                        assert await why() == "it has the type std_msgs/msg/String, not nav_msgs/msg/Odometry"
