"""Poses of a world that have names."""

from __future__ import annotations

from dataclasses import dataclass

from sim_nodes.files import FileError
from sim_nodes.geometry import Vector, quaternion
from sim_nodes.physics import BodyState
from sim_nodes.worlds.schema import NamedPoseFile


@dataclass(frozen=True)
class NamedPose:
    """A pose with a name, and how much room there is: lower and upper corner of a box along its axes [m]."""

    name: str
    description: str
    tags: tuple[str, ...]
    place: BodyState
    room: tuple[Vector, Vector] | None


def read_pose(pose: NamedPoseFile, index: int, extent: tuple[float, float, float, float]) -> NamedPose:
    """A named pose of a world file.

    Args:
        pose: What the file says.
        index: Which of the poses it is, from 0.
        extent: Of the world's map: lower x, y, upper x, y [m].

    Raises:
        FileError: It is not in the world.
    """
    at, (left, bottom, right, top) = pose.pose, extent
    if not (left <= at.x <= right and bottom <= at.y <= top):
        raise FileError(
            f"poses.{index}.pose: {pose.name!r} at ({at.x:g}, {at.y:g}) is outside of the world, "
            f"which reaches from ({left:g}, {bottom:g}) to ({right:g}, {top:g})"
        )
    place = BodyState((at.x, at.y, at.z or 0.0), quaternion(at.roll, at.pitch, at.yaw))
    room = None if pose.bounds is None else (pose.bounds.lower, pose.bounds.upper)
    return NamedPose(pose.name, pose.description, pose.tags, place, room)
