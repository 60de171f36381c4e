"""A simulated robot as ROS 2 topics, with the names of a TurtleBot 4 or an arm of UR.

Frames have no prefixes: as in Nav2 with several robots, each robot has `tf` and `tf_static` in its own namespace.
"""

from __future__ import annotations

import logging
import math
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.expose import messages
from seoro.bridges.ros2.expose.arms import ExposedArm, serving_arm
from seoro.bridges.ros2.expose.messages import MAP, ODOM
from seoro.bridges.ros2.expose.navigation import serving_navigation
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.expose.sensors import SENSOR_DATA, TOPICS, SensorTopics
from seoro.bridges.ros2.interfaces import InvalidPayload, Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Publication, Subscription
from seoro.bridges.ros2.urdf import Links, read_links
from seoro.bridges.ros2.wire import LATCHED, Qos
from seoro.bridges.session import Bound
from seoro.concurrency.background import background
from seoro.errors import BackendRefused

LATEST = Bound(1)  # queue of commands
POSED = "geometry_msgs/msg/PoseWithCovarianceStamped"
SENSED = ("lidar", "odometry", "imu")

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ExposedRobot:
    """A robot to expose.

    Attributes:
        name: Name of the robot.
        description: Description of the robot.
        stamped: Whether velocity commands have stamps.
        navigates: Whether to expose the navigation of a driving robot.
    """

    name: str
    description: wire.RobotDescription
    stamped: bool = False
    navigates: bool = True

    @property
    def drives(self) -> bool:
        """Whether the robot has a driving base."""
        return self.description.max_speed > 0.0


def stream_of(robots: Sequence[ExposedRobot], identifier: str) -> wire.OpenStream:
    """Return the request of a stream of the data of robots."""
    sensed = [(each.name, sensor) for each in robots for sensor in SENSED if sensor in each.description.sensors]
    return wire.OpenStream(
        id=identifier,
        sensors=tuple(wire.SensorName(robot=name, sensor=sensor) for name, sensor in sensed),
        poses=tuple(each.name for each in robots if each.drives and each.navigates),
        joints=tuple(each.name for each in robots),
        batteries=tuple(each.name for each in robots if each.description.has_battery),
    )


class RobotTopics:
    """Published topics of a robot.

    Args:
        robot: The robot.
        topics: Publishers by the names of their topics.
        sensors: Topics of its cameras and listed sensors.

    Attributes:
        robot: The robot.
        sensors: Topics of its cameras and listed sensors.
        links: Links and joints of the robot.
        estimate: Estimated pose in the map; None while it is unknown.
        positions: Positions of the joints [rad, m], by name.
    """

    def __init__(
        self, robot: ExposedRobot, topics: dict[str, Publication], sensors: Sequence[SensorTopics]
    ) -> None:
        self.robot = robot
        self.sensors = sensors
        self._topics = topics
        self.links: Links = read_links(robot.description.urdf)
        self._base = robot.description.base_link
        self.estimate: wire.Pose3D | None = None
        self.positions: dict[str, float] = {}

    def describe(self, base_in_map: wire.Pose3D | None) -> None:
        """Publish the static transforms and the description.

        Args:
            base_in_map: Pose of a fixed base.
        """
        fixed = self.links.fixed()
        fixed += [transform for sensor in self.sensors for transform in sensor.transforms()]
        if base_in_map is not None:
            fixed.append(messages.transform(MAP, self._base, base_in_map, 0.0))
        self._topics["tf_static"].publish({"transforms": fixed})
        self._topics["robot_description"].publish({"data": self.robot.description.urdf})

    def publish_sample(self, sample: wire.SensorSample) -> None:
        """Publish a sensor sample."""
        time, lidar = sample.time, self.robot.description.lidar
        if sample.lidar is not None and lidar is not None:
            self._topics["scan"].publish(messages.laser_scan(sample.lidar, lidar, time))
        if sample.odometry is not None:
            self._topics["odom"].publish(messages.odometry(sample.odometry, self._base, time))
            self._transform(messages.transform(ODOM, self._base, sample.odometry.pose, time))
        if sample.imu is not None:
            self._topics["imu"].publish(messages.imu(sample.imu, self._base, time))

    def publish_pose(self, pose: wire.StreamedPose, time: float) -> None:
        """Publish the estimated pose of the robot."""
        self.estimate = pose.base
        self._topics["amcl_pose"].publish(messages.estimated_pose(pose, time))
        self._transform(messages.transform(MAP, ODOM, pose.odom, time))

    def publish_joints(self, joints: wire.JointStates, time: float) -> None:
        """Publish the joint states, and the transforms of the links."""
        self._topics["joint_states"].publish(messages.joint_state(joints, time))
        self.positions = dict(zip(joints.names, joints.positions, strict=True))
        moving = self.links.moving(self.positions, time)
        if moving:
            self._topics["tf"].publish({"transforms": moving})

    def publish_battery(self, charge: float, time: float) -> None:
        """Publish the charge of the battery."""
        self._topics["battery_state"].publish(messages.battery_state(charge, self._base, time))

    def _transform(self, transform: dict[str, Any]) -> None:
        self._topics["tf"].publish({"transforms": [transform]})


@asynccontextmanager
async def exposing_robot(ros: RosNode, node: ExposedNode, robot: ExposedRobot) -> AsyncIterator[RobotTopics]:
    """Expose a robot by its own ROS node during the block.

    Args:
        ros: ROS node in the namespace of the robot.
        node: Simulator node of the robot.
        robot: The robot.
    """
    async with AsyncExitStack() as stack:
        topics = {
            topic: await stack.enter_async_context(ros.publishing(topic, kind, qos))
            for topic, kind, qos in _published(robot)
        }
        sensors = [await _sensor_topics(stack, ros, robot.name, each) for each in robot.description.mounted]
        published = RobotTopics(robot, topics, sensors)
        published.describe(None if robot.drives else await _true_pose(node, robot.name))
        if robot.drives:
            await stack.enter_async_context(_subscribing_to_velocity(ros, node, robot))
        if robot.drives and robot.navigates:
            topics["map"].publish(messages.occupancy_grid(await node.ask(wire.GET_MAP, wire.Empty())))
            await stack.enter_async_context(_subscribing_to_initial_pose(ros, node, robot))
            await stack.enter_async_context(serving_navigation(ros, node, robot.name, lambda: published.estimate))
        if robot.description.arm is not None:
            arm = ExposedArm(node, robot.name, published.links, lambda: published.positions)
            await stack.enter_async_context(serving_arm(ros, arm))
        yield published


async def _sensor_topics(
    stack: AsyncExitStack, ros: RosNode, robot: str, sensor: wire.MountedSensor
) -> SensorTopics:
    topics = {
        topic: await stack.enter_async_context(ros.publishing(f"{sensor.name}/{topic}", kind, SENSOR_DATA))
        for topic, kind in TOPICS.get(sensor.kind, {}).items()  # a newer node may have further kinds
    }
    return SensorTopics(robot, sensor, topics)


def _published(robot: ExposedRobot) -> list[tuple[str, str, Qos | None]]:
    topics: list[tuple[str, str, Qos | None]] = [
        ("joint_states", "sensor_msgs/msg/JointState", None),
        ("tf", "tf2_msgs/msg/TFMessage", Qos(depth=100)),
        ("tf_static", "tf2_msgs/msg/TFMessage", LATCHED),
        ("robot_description", "std_msgs/msg/String", LATCHED),
    ]
    if robot.drives:
        topics += [
            ("scan", "sensor_msgs/msg/LaserScan", None),
            ("odom", "nav_msgs/msg/Odometry", None),
        ]
    if robot.drives and robot.navigates:
        topics += [("amcl_pose", POSED, LATCHED), ("map", "nav_msgs/msg/OccupancyGrid", LATCHED)]
    if "imu" in robot.description.sensors:
        topics.append(("imu", "sensor_msgs/msg/Imu", None))
    if robot.description.has_battery:
        topics.append(("battery_state", "sensor_msgs/msg/BatteryState", None))
    return topics


async def _true_pose(node: ExposedNode, robot: str) -> wire.Pose3D:
    return (await node.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=robot))).pose


def _subscribing_to_velocity(
    ros: RosNode, node: ExposedNode, robot: ExposedRobot
) -> AbstractAsyncContextManager[None]:
    async def command(message: Any) -> None:
        twist = _limited(robot.description, geometry.twist(message.twist if robot.stamped else message))
        await node.ask(wire.CMD_VEL, wire.CmdVel(robot=robot.name, twist=twist))

    velocity = "geometry_msgs/msg/TwistStamped" if robot.stamped else "geometry_msgs/msg/Twist"
    return _handling(ros, "cmd_vel", velocity, command)


def _subscribing_to_initial_pose(
    ros: RosNode, node: ExposedNode, robot: ExposedRobot
) -> AbstractAsyncContextManager[None]:
    async def set_pose(message: Any) -> None:
        if (frame := message.header.frame_id) not in ("", MAP):
            raise ValueError(f"unsupported frame {frame!r} of the initial pose: expected {MAP!r}")
        pose = geometry.pose(message.pose.pose)
        await node.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=robot.name, pose=pose))

    return _handling(ros, "initialpose", POSED, set_pose)


def _limited(description: wire.RobotDescription, twist: wire.Twist) -> wire.Twist:
    """Limit a velocity to the speeds and directions of a base.

    Raises:
        ValueError: The velocity is not finite.
    """
    if not (math.isfinite(twist.linear.x) and math.isfinite(twist.angular.z)):
        raise ValueError("the velocity is not finite")
    speed, turn_rate = description.max_speed, description.max_turn_rate
    linear = max(-speed, min(speed, twist.linear.x))
    angular = max(-turn_rate, min(turn_rate, twist.angular.z))
    return wire.Twist(linear=wire.Vector3(x=linear), angular=wire.Vector3(z=angular))


@asynccontextmanager
async def _handling(
    ros: RosNode, topic: str, type_name: str, handle: Callable[[Message], Awaitable[None]]
) -> AsyncIterator[None]:
    """Handle the latest message of a topic during the block; log each failure once in a row."""

    async def handle_all(subscription: Subscription) -> None:
        logged = ""
        async for received in subscription:
            try:
                await handle(subscription.decode(received))
            except (BackendRefused, ValueError, InvalidPayload, DefinitionMismatch) as error:
                if str(error) != logged:
                    logged = str(error)
                    log.warning("%s: %s", subscription.topic, logged)

    async with ros.subscribing(topic, type_name, bound=LATEST) as subscription, background() as tasks:
        tasks.start_soon(handle_all, subscription)
        yield
