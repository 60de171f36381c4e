"""Parts of robots that are topics, services or actions, with their types and usual names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.participant import BRIDGE, GUARD
from seoro.bridges.ros2.robots.arm import FOLLOWS, GRIPS, PLANS
from seoro.bridges.ros2.robots.base import ODOMETRY
from seoro.bridges.ros2.robots.joints import JOINT_STATES
from seoro.bridges.ros2.robots.localisation import POSE
from seoro.bridges.ros2.robots.navigation import FOLLOW_WAYPOINTS, NAVIGATE_THROUGH_POSES, NAVIGATE_TO_POSE
from seoro.bridges.ros2.robots.sensing import DETECTIONS, WRENCH
from seoro.bridges.ros2.robots.velocity import TYPES
from seoro.bridges.ros2.wire import Endpoint, Kind

BATTERY: Final = "sensor_msgs/msg/BatteryState"
TRANSFORMS: Final = "tf2_msgs/msg/TFMessage"
STRING: Final = "std_msgs/msg/String"
EMPTY: Final = "std_srvs/srv/Empty"


@dataclass(frozen=True)
class Part:
    """Part of a robot that is a topic, service or action.

    Attributes:
        kind: Kind of the endpoint of the robot.
        types: Accepted types.
        names: Usual names, the most usual first.
        is_named: Whether only endpoints of these names count; otherwise all of the types do.
    """

    kind: Kind
    types: Sequence[str]
    names: Sequence[str]
    is_named: bool = False


SUBSCRIBES, PUBLISHES, SERVES, ACTS = Kind.SUBSCRIPTION, Kind.PUBLISHER, Kind.SERVER, Kind.ACTION_SERVER
PARTS: Final[Mapping[str, Part]] = {
    "cmd_vel": Part(SUBSCRIBES, TYPES, ("cmd_vel",)),
    "odometry": Part(PUBLISHES, (ODOMETRY,), ("odom", "filtered", "odometry")),
    "initial_pose": Part(SUBSCRIBES, (POSE,), ("initialpose",), is_named=True),
    "pose": Part(PUBLISHES, (POSE,), ("amcl_pose", "pose"), is_named=True),
    "global_localization": Part(SERVES, (EMPTY,), ("reinitialize_global_localization",), is_named=True),
    "navigate_to_pose": Part(ACTS, (NAVIGATE_TO_POSE,), ("navigate_to_pose",)),
    "navigate_through_poses": Part(ACTS, (NAVIGATE_THROUGH_POSES,), ("navigate_through_poses",)),
    "follow_waypoints": Part(ACTS, (FOLLOW_WAYPOINTS,), ("follow_waypoints",)),
    "trajectory": Part(ACTS, (FOLLOWS,), ("follow_joint_trajectory",)),
    "joint_states": Part(PUBLISHES, (JOINT_STATES,), ("joint_states",)),
    "move_group": Part(ACTS, (PLANS,), ("move_action",)),
    "gripper": Part(ACTS, (GRIPS,), ("gripper_cmd",)),
    "battery": Part(PUBLISHES, (BATTERY,), ("battery_state", "battery")),
    "tf": Part(PUBLISHES, (TRANSFORMS,), ("tf",), is_named=True),
    "tf_static": Part(PUBLISHES, (TRANSFORMS,), ("tf_static",), is_named=True),
    "force": Part(PUBLISHES, (WRENCH,), ()),
    "sight": Part(PUBLISHES, (DETECTIONS,), ()),
    "description": Part(PUBLISHES, (STRING,), ("robot_description",), is_named=True),
    "semantics": Part(PUBLISHES, (STRING,), ("robot_description_semantic",), is_named=True),
    "lidar": Part(PUBLISHES, ("sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2"), ("scan",)),
    "camera": Part(PUBLISHES, ("sensor_msgs/msg/CameraInfo",), ("camera_info",)),
    "imu": Part(PUBLISHES, ("sensor_msgs/msg/Imu",), ("imu",)),
}


def all_endpoints(graph: RosGraph) -> list[Endpoint]:
    """Return all endpoints of a system, with the servers of its actions."""
    actions = [each for name in graph.actions() for each in graph.action_servers(name)]
    return [*(each for each in graph.endpoints() if each.kind is not ACTS), *actions]


def is_of_bridge(endpoint: Endpoint) -> bool:
    """Return whether an endpoint belongs to a bridge of seoro or its guard."""
    return endpoint.node is not None and endpoint.node.name in (BRIDGE, GUARD)
