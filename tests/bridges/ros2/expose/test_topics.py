from __future__ import annotations

import math
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import anyio
import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.geometry import seconds
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import LATCHED
from seoro.bridges.session import open_session
from tests.bridges.ros2.expose.exposed import KEEPING, exposed, first, step
from tests.routers import free_endpoint

pytestmark = pytest.mark.engine("mujoco")

POSED = "geometry_msgs/msg/PoseWithCovarianceStamped"


async def transforms(subscription: Subscription, count: int) -> dict[tuple[str, str], Any]:
    """Return the last transforms of some messages, by parent and child."""
    return {
        (each.header.frame_id, each.child_frame_id): each.transform
        for message in await first(subscription, count)
        for each in message.transforms
    }


async def test_a_robot_publishes_its_sensor_data(simulator: str, router: str, types: TypeStore) -> None:
    async with (
        exposed(simulator, router, types, "maze") as node,
        node.ros.subscribing("/turtlebot4/scan", "sensor_msgs/msg/LaserScan") as scans,
        node.ros.subscribing("/turtlebot4/odom", "nav_msgs/msg/Odometry", KEEPING) as odometry,
        node.ros.subscribing("/turtlebot4/imu", "sensor_msgs/msg/Imu") as imus,
        node.ros.subscribing("/turtlebot4/joint_states", "sensor_msgs/msg/JointState") as joints,
        node.ros.subscribing("/turtlebot4/tf", "tf2_msgs/msg/TFMessage", KEEPING) as tf,
        node.ros.subscribing("/turtlebot4/tf_static", "tf2_msgs/msg/TFMessage", LATCHED) as tf_static,
        node.ros.subscribing("/turtlebot4/robot_description", "std_msgs/msg/String", LATCHED) as urdf,
        node.ros.subscribing("/clock", "rosgraph_msgs/msg/Clock", KEEPING) as clock,
    ):
        await step(node, 100)  # of 4 ms
        [scan] = await first(scans)
        assert scan.header.frame_id == "rplidar_link"
        assert seconds(scan.header.stamp) == pytest.approx(0.1)
        assert (scan.angle_min, scan.angle_increment) == pytest.approx((-math.pi, math.tau / 360))
        truth = await node.ask(wire.GET_SENSOR_SAMPLE, wire.SensorName(robot="turtlebot4", sensor="lidar"))
        assert truth.lidar is not None
        await first(scans, 2)
        [last] = await first(scans)
        np.testing.assert_allclose(last.ranges, np.array(truth.lidar.ranges, dtype=np.float32))
        stamps = [seconds(message.header.stamp) for message in await first(odometry, 20)]
        assert stamps == pytest.approx([0.02 * tick for tick in range(1, 21)])
        assert [seconds(each.clock) for each in await first(clock, 20)] == pytest.approx(stamps)
        [imu] = await first(imus)
        assert imu.linear_acceleration.z == pytest.approx(9.81, abs=0.3)
        assert imu.orientation_covariance[0] == -1.0
        [joint] = await first(joints)
        assert list(joint.name) == ["left_wheel_joint", "right_wheel_joint"]
        moving = await transforms(tf, 40)
        assert set(moving) == {("odom", "base_link"), ("base_link", "left_wheel"), ("base_link", "right_wheel")}
        fixed = await transforms(tf_static, 1)
        assert fixed["base_link", "rplidar_link"].translation.z == pytest.approx(0.193)
        assert (await first(urdf))[0].data.startswith("<?xml")


async def test_a_robot_follows_velocities_and_an_initial_pose(
    simulator: str, router: str, types: TypeStore
) -> None:
    async with (
        exposed(simulator, router, types, rate=4.0) as node,
        node.ros.publishing("/turtlebot4/cmd_vel", "geometry_msgs/msg/Twist") as commands,
        node.ros.publishing("/turtlebot4/initialpose", POSED) as places,
        node.ros.subscribing("/turtlebot4/odom", "nav_msgs/msg/Odometry") as odometry,
        node.ros.subscribing("/turtlebot4/amcl_pose", POSED) as poses,
    ):
        place = {
            "header": {"frame_id": "map"},
            "pose": {"pose": {"position": {"x": 0.5}, "orientation": {"z": 1.0, "w": 0.0}}},
        }
        places.publish(place)
        [believed] = await first(poses)
        assert believed.pose.pose.position.x == pytest.approx(0.5, abs=0.1)
        assert abs(believed.pose.pose.orientation.z) > 0.95
        assert 0.0 < believed.pose.covariance[0] < 0.1
        travelled = 0.0
        while travelled < 0.05:
            commands.publish({"linear": {"x": 99.0}})
            [at] = await first(odometry)
            assert at.twist.twist.linear.x < 0.35
            travelled = at.pose.pose.position.x


async def test_invalid_velocities_are_logged_and_ignored(
    simulator: str, router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    async with (
        exposed(simulator, router, types, rate=math.inf, root="turtlebot4") as node,
        node.ros.publishing("/cmd_vel", "geometry_msgs/msg/Twist") as commands,
        node.ros.publishing("/initialpose", POSED) as places,
        node.ros.subscribing("/odom", "nav_msgs/msg/Odometry") as odometry,
    ):
        while "/initialpose: unsupported frame 'odom' of the initial pose: expected 'map'" not in caplog.text:
            places.publish({"header": {"frame_id": "odom"}})
            [at] = await first(odometry)
        while "/cmd_vel: the velocity is not finite" not in caplog.text:
            commands.publish({"linear": {"x": math.nan}})
            [at] = await first(odometry)
        while "invalid or truncated message" not in caplog.text:
            commands.send(b"\x00\x01\x00\x00nonsense")
            [at] = await first(odometry)
        assert at.pose.pose.position.x == pytest.approx(0.0, abs=1e-3)
        assert caplog.text.count("not finite") == 1


async def test_navigation_may_be_left_to_other_nodes(simulator: str, router: str, types: TypeStore) -> None:
    async with (
        exposed(simulator, router, types, "maze", navigation=False) as node,
        node.ros.subscribing("/turtlebot4/tf", "tf2_msgs/msg/TFMessage", KEEPING) as tf,
    ):
        graph = node.ros.graph
        assert graph.actions().keys() == {"/simulate_steps"}
        assert not {"/turtlebot4/amcl_pose", "/turtlebot4/map", "/turtlebot4/initialpose"} & graph.topics().keys()
        await node.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot="turtlebot4", pose=wire.Pose3D()))
        await step(node, 100)
        assert {parent for parent, _ in await transforms(tf, 40)} == {"odom", "base_link"}


async def test_the_map_is_published_for_late_subscriptions(simulator: str, router: str, types: TypeStore) -> None:
    async with (
        exposed(simulator, router, types, "maze") as node,
        node.ros.subscribing("/turtlebot4/map", "nav_msgs/msg/OccupancyGrid", LATCHED) as maps,
    ):
        [grid] = await first(maps)
        assert grid.info.resolution == pytest.approx(0.05)
        assert len(grid.data) == grid.info.width * grid.info.height
        assert set(np.unique(grid.data)) == {0, 100}


@pytest.mark.more
async def test_an_exposed_node_reappears_after_a_restart_of_the_router(simulator: str, types: TypeStore) -> None:
    endpoint = free_endpoint()
    async with AsyncExitStack() as stack:
        async with open_session(listen=endpoint, gossip=True):
            node = await stack.enter_async_context(exposed(simulator, endpoint, types, rate=1.0))
            odometry = node.ros.subscribing("/turtlebot4/odom", "nav_msgs/msg/Odometry")
            reported = await stack.enter_async_context(odometry)
            calling = node.ros.calling("/get_entities", "simulation_interfaces/srv/GetEntities")
            client = await stack.enter_async_context(calling)
            [before] = await first(reported)
        async with open_session(listen=endpoint, gossip=True):
            with anyio.fail_after(20.0):
                while seconds((await reported.message()).header.stamp) < seconds(before.header.stamp) + 2.0:
                    pass
                await client.wait_for_server()
            assert list((await client.call({}, 5.0)).entities) == ["turtlebot4"]
            await stack.aclose()


async def test_robots_with_a_battery_publish_its_state(
    simulator: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    world = tmp_path / "fleet.yaml"
    battery = "battery: {capacity: 0.1, idle: 18, driving: 54, charge: 0.9}"
    world.write_text(
        f"name: fleet\nextent: [-4, -4, 4, 4]\nrobots: [{{name: one, robot: turtlebot4, {battery}}},\n"
        "  {name: two, robot: turtlebot4, pose: {y: 2}}]\n"
    )
    async with (
        exposed(simulator, router, types, str(world)) as node,
        node.ros.subscribing("/one/battery_state", "sensor_msgs/msg/BatteryState", KEEPING) as batteries,
    ):
        await step(node, 500)  # of 4 ms
        first_one, second_one = await first(batteries, 2)
        assert [seconds(each.header.stamp) for each in (first_one, second_one)] == [1.0, 2.0]
        assert [each.percentage for each in (first_one, second_one)] == pytest.approx([0.85, 0.8])
        assert second_one.present
        assert math.isnan(second_one.voltage)
        assert not node.ros.system.graph.publishers("/two/battery_state")
