"""Values of the runtime as they are said on the wire."""

from __future__ import annotations

from typing import Any

from seoro.bridges import wire
from seoro.runtime.contracts import Orientation3D, Pose3D, Position3D, Velocity6D


def vector_message(position: Position3D) -> wire.Vector3:
    """A position [m]."""
    return wire.Vector3(x=position.x, y=position.y, z=position.z)


def pose_message(pose: Pose3D) -> wire.Pose:
    """A pose [m, rad]."""
    turned = pose.orientation
    return wire.Pose(
        position=vector_message(pose.position),
        orientation=wire.Orientation(roll=turned.roll, pitch=turned.pitch, yaw=turned.yaw),
    )


def twist_message(velocity: Velocity6D) -> wire.Twist:
    """A velocity [m/s, rad/s]."""
    linear, angular = velocity.translational, velocity.angular
    return wire.Twist(
        linear=wire.Vector3(x=linear.x, y=linear.y, z=linear.z),
        angular=wire.Vector3(x=angular.roll, y=angular.pitch, z=angular.yaw),
    )


def contact_arguments(contact: wire.Contact) -> dict[str, Any]:
    """A contact, as `contracts.Contact` takes it."""
    place, found = contact.position, contact.model_dump(exclude_defaults=True)
    if contact.strikers is not None:
        found["strikers"] = list(contact.strikers)
    if place is not None:
        found["position"] = [place.x, place.y, place.z]
    return found


def departure_arguments(departure: wire.Departure) -> dict[str, Any]:
    """Return the arguments of the event of a robot that left its world: `time`, `robot` and `reason`."""
    place = departure.position
    left, lower, right, upper = departure.extent
    where = f"({place.x:.3f}, {place.y:.3f}, {place.z:.3f}) m"
    reason = (
        f"{departure.robot} left the world at {where}, {departure.time:.3f} s after the start; expected "
        f"x from {left:g} to {right:g} m and y from {lower:g} to {upper:g} m: "
        "keep the robot inside, or enlarge the `extent` of the world file"
    )
    return {"time": departure.time, "robot": departure.robot, "reason": reason}


def pose_value(pose: wire.Pose) -> Pose3D:
    """A pose [m, rad] that was said on the wire."""
    place, turned = pose.position, pose.orientation
    return Pose3D(Position3D(place.x, place.y, place.z), Orientation3D(turned.roll, turned.pitch, turned.yaw))
