"""Names and poses of robots in a ROS 2 system."""

from __future__ import annotations

from typing import Any

from seoro.robotics.geometry import Pose3D, quaternion
from seoro.runtime.contracts.ros2 import ObservedSystem, RobotNames
from seoro.runtime.values.values import Actor


def full_name(robot: Actor, namespace_override: str, name: str) -> str:
    """Return the full name of a topic, service or action of a robot; one with a leading slash is full."""
    return RobotNames(namespace=_own_namespace(robot, namespace_override)).full(name)


def observed_names(robot: Actor, system: ObservedSystem, name: str, override: str = "") -> RobotNames:
    """Return the names of the topics of an observed robot.

    Args:
        robot: Actor of the robot; its namespace takes precedence over that of the system.
        system: System of the robot.
        name: Name of the robot there.
        override: Namespace that takes precedence over both.
    """
    names, own = system.names_of(name), _own_namespace(robot, override)
    return names.below(own) if own else names


def _own_namespace(robot: Actor, override: str) -> str:
    return (override or str(robot.fields.get("namespace", ""))).strip("/")


def pose_message(pose: Pose3D) -> dict[str, Any]:
    """Return a `geometry_msgs/Pose`."""
    position, angles = pose.position, pose.orientation
    return {
        "position": {"x": position.x, "y": position.y, "z": position.z},
        "orientation": quaternion(angles.roll, angles.pitch, angles.yaw)._asdict(),
    }
