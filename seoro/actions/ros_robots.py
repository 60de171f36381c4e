"""Names and poses of robots in a ROS 2 system."""

from __future__ import annotations

from typing import Any

from seoro.robotics.geometry import Pose3D, quaternion
from seoro.runtime.contracts.ros2 import ObservedSystem
from seoro.runtime.values.values import Actor


def full_name(robot: Actor, namespace_override: str, name: str) -> str:
    """Return the full name of a topic, service or action of a robot; one with a leading slash is full."""
    namespace = (namespace_override or str(robot.fields.get("namespace", ""))).strip("/")
    return name if name.startswith("/") else f"/{namespace}/{name}" if namespace else f"/{name}"


def observed_namespace(robot: Actor, system: ObservedSystem, name: str, override: str = "") -> str:
    """Return the namespace of an observed robot, without slashes around it.

    Args:
        robot: Actor of the robot; its namespace takes precedence over that of the system.
        system: System of the robot.
        name: Name of the robot there.
        override: Namespace that takes precedence over both.
    """
    own = (override or str(robot.fields.get("namespace", ""))).strip("/")
    return own or system.namespace_of(name)


def pose_message(pose: Pose3D) -> dict[str, Any]:
    """Return a `geometry_msgs/Pose`."""
    position, angles = pose.position, pose.orientation
    return {
        "position": {"x": position.x, "y": position.y, "z": position.z},
        "orientation": quaternion(angles.roll, angles.pitch, angles.yaw)._asdict(),
    }
