"""Conversion between values of the runtime and messages."""

from __future__ import annotations

from typing import Any

from seoro.bridges import wire
from seoro.robotics.geometry import Velocity6D


def twist_message(velocity: Velocity6D) -> wire.Twist:
    """Convert a velocity [m/s, rad/s] to its message."""
    linear, angular = velocity.translational, velocity.angular
    return wire.Twist(
        linear=wire.Vector3(x=linear.x, y=linear.y, z=linear.z),
        angular=wire.Vector3(x=angular.roll, y=angular.pitch, z=angular.yaw),
    )


def contact_arguments(contact: wire.Contact) -> dict[str, Any]:
    """Return the arguments of the event of a contact, for `contracts.contacts.Contact.of`."""
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
        f"x from {left:g} to {right:g} m and y from {lower:g} to {upper:g} m "
        "(`extent` of the world file)"
    )
    return {"time": departure.time, "robot": departure.robot, "reason": reason}
