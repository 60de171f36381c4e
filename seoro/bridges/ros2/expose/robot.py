"""A robot of a simulator as topics of ROS 2, under the names that a TurtleBot 4 or an arm of UR has them.

Frames have no prefixes: as Nav2 has it for many robots, each has `tf` and `tf_static` in its own namespace.
"""

from __future__ import annotations

import logging
import math
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from typing import Any

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.expose import messages
from seoro.bridges.ros2.expose.arms import ExposedArm, serving_arm
from seoro.bridges.ros2.expose.links import Links, read_links
from seoro.bridges.ros2.expose.messages import MAP, ODOM
from seoro.bridges.ros2.expose.navigation import serving_navigation
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.interfaces import InvalidPayload, Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Publication, Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.bridges.session import Bound
from seoro.errors import BackendRefused

LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
LATEST = Bound(1)  # of what commands a robot, only the last counts
POSED = "geometry_msgs/msg/PoseWithCovarianceStamped"
SENSED = ("lidar", "odometry", "imu")

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ExposedRobot:
    """A robot.

    Attributes:
        name: Its name.
        description: What it is made of.
        stamped: Whether commands of velocity have stamps.
        navigates: Whether it finds its way by itself, if it drives.
    """

    name: str
    description: wire.RobotDescription
    stamped: bool = False
    navigates: bool = True

    @property
    def drives(self) -> bool:
        """Whether it has a base that drives."""
        return self.description.max_speed > 0.0

    @property
    def wanted(self) -> wire.OpenStream:
        """What has to be streamed of it."""
        sensors = tuple(name for name in SENSED if name in self.description.sensors)
        return wire.OpenStream(
            id="",
            sensors=tuple(wire.SensorName(robot=self.name, sensor=sensor) for sensor in sensors),
            poses=(self.name,) if self.drives and self.navigates else (),
            joints=(self.name,),
            batteries=(self.name,) if self.description.has_battery else (),
        )


class RobotTopics:
    """The topics that a robot publishes.

    Args:
        robot: The robot.
        topics: Its publications by the names of their topics.

    Attributes:
        links: Its links and joints.
        believed: Where it believes to be in the map; None as long as it does not know.
        positions: Where its joints are [rad, m], by their names.
    """

    def __init__(self, robot: ExposedRobot, topics: dict[str, Publication]) -> None:
        self._robot = robot
        self._topics = topics
        self.links: Links = read_links(robot.description.urdf)
        self._base = robot.description.base_link
        self.believed: wire.Pose | None = None
        self.positions: dict[str, float] = {}

    def describe(self, base_in_map: wire.Pose | None) -> None:
        """Publish once what does not change.

        Args:
            base_in_map: Where the base stands, if it does not move.
        """
        fixed = self.links.fixed()
        if base_in_map is not None:
            fixed.append(messages.transform(MAP, self._base, base_in_map, 0.0))
        self._topics["tf_static"].publish({"transforms": fixed})
        self._topics["robot_description"].publish({"data": self._robot.description.urdf})

    def publish_sample(self, sample: wire.SensorSample) -> None:
        """Publish what a sensor says."""
        time, lidar = sample.time, self._robot.description.lidar
        if sample.lidar is not None and lidar is not None:
            self._topics["scan"].publish(messages.laser_scan(sample.lidar, lidar, time))
        if sample.odometry is not None:
            self._topics["odom"].publish(messages.odometry(sample.odometry, self._base, time))
            self._transform(messages.transform(ODOM, self._base, sample.odometry.pose, time))
        if sample.imu is not None:
            self._topics["imu"].publish(messages.imu(sample.imu, self._base, time))

    def publish_pose(self, told: wire.StreamedPose, time: float) -> None:
        """Publish where the robot believes that it is."""
        self.believed = told.base
        self._topics["amcl_pose"].publish(messages.believed_pose(told, time))
        self._transform(messages.transform(MAP, ODOM, told.odom, time))

    def publish_joints(self, joints: wire.JointStates, time: float) -> None:
        """Publish how its joints are, and the transforms that follow from that."""
        self._topics["joint_states"].publish(messages.joint_state(joints, time))
        self.positions = dict(zip(joints.names, joints.positions, strict=True))
        moving = self.links.moving(self.positions, time)
        if moving:
            self._topics["tf"].publish({"transforms": moving})

    def publish_battery(self, charge: float, time: float) -> None:
        """Publish how its battery is."""
        self._topics["battery_state"].publish(messages.battery_state(charge, self._base, time))

    def _transform(self, transform: dict[str, Any]) -> None:
        self._topics["tf"].publish({"transforms": [transform]})


@asynccontextmanager
async def exposing_robot(ros: RosNode, node: ExposedNode, robot: ExposedRobot) -> AsyncIterator[RobotTopics]:
    """Expose a robot by a ROS node of its own, for as long as the block lasts.

    Args:
        ros: The ROS node, in the namespace of the robot.
        node: The simulator node that the robot is in.
        robot: The robot.
    """
    async with AsyncExitStack() as stack:
        topics = {
            topic: await stack.enter_async_context(ros.publishing(topic, kind, qos))
            for topic, kind, qos in _published(robot)
        }
        told = RobotTopics(robot, topics)
        told.describe(None if robot.drives else await _place(node, robot.name))
        if robot.drives:
            await stack.enter_async_context(_commanding(ros, node, robot))
        if robot.drives and robot.navigates:
            topics["map"].publish(messages.occupancy_grid(await node.ask(wire.GET_MAP, wire.Empty())))
            await stack.enter_async_context(_locating(ros, node, robot))
            await stack.enter_async_context(serving_navigation(ros, node, robot.name, lambda: told.believed))
        if robot.description.arm is not None:
            arm = ExposedArm(node, robot.name, told.links, lambda: told.positions)
            await stack.enter_async_context(serving_arm(ros, arm))
        yield told


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


async def _place(node: ExposedNode, robot: str) -> wire.Pose:
    return (await node.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=robot))).pose


@asynccontextmanager
async def _commanding(ros: RosNode, node: ExposedNode, robot: ExposedRobot) -> AsyncIterator[None]:
    """Take velocities."""

    async def command(message: Any) -> None:
        twist = _within(robot.description, geometry.twist(message.twist if robot.stamped else message))
        await node.ask(wire.CMD_VEL, wire.CmdVel(robot=robot.name, twist=twist))

    velocity = "geometry_msgs/msg/TwistStamped" if robot.stamped else "geometry_msgs/msg/Twist"
    async with ros.subscribing("cmd_vel", velocity, bound=LATEST) as velocities, background() as tasks:
        tasks.start_soon(_obey, velocities, command)
        yield


@asynccontextmanager
async def _locating(ros: RosNode, node: ExposedNode, robot: ExposedRobot) -> AsyncIterator[None]:
    """Take initial poses."""

    async def place(message: Any) -> None:
        if (frame := message.header.frame_id) not in ("", MAP):
            raise ValueError(f"the initial pose is in the frame {frame!r}: give it in {MAP!r}")
        pose = geometry.pose(message.pose.pose)
        await node.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=robot.name, pose=pose))

    async with ros.subscribing("initialpose", POSED, bound=LATEST) as poses, background() as tasks:
        tasks.start_soon(_obey, poses, place)
        yield


def _within(description: wire.RobotDescription, twist: wire.Twist) -> wire.Twist:
    """A velocity as a base carries it out, which is as fast as it can be, and ahead or about itself.

    Raises:
        ValueError: A part of it is no number.
    """
    if not (math.isfinite(twist.linear.x) and math.isfinite(twist.angular.z)):
        raise ValueError("a velocity has a part that is no number")
    fastest, quickest = description.max_speed, description.max_turn_rate
    ahead = max(-fastest, min(fastest, twist.linear.x))
    turn = max(-quickest, min(quickest, twist.angular.z))
    return wire.Twist(linear=wire.Vector3(x=ahead), angular=wire.Vector3(z=turn))


async def _obey(subscription: Subscription, carry_out: Callable[[Message], Awaitable[None]]) -> None:
    """Carry out what arrives; what cannot be is said once, until something else is wrong."""
    said = ""
    async for received in subscription:
        try:
            await carry_out(subscription.decode(received))
        except (BackendRefused, ValueError, InvalidPayload, DefinitionMismatch) as error:
            if str(error) != said:
                said = str(error)
                log.warning("%s: %s", subscription.topic, said)
