"""Named poses of worlds, and free starting positions."""

from __future__ import annotations

import numpy as np

from seoro.deferred import dataclass
from seoro.files.yaml_lines import FileError
from sim_nodes.geometry import Pose2, Vector, quaternion
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.physics import BodyState
from sim_nodes.terrain.ground import FLAT, Ground
from sim_nodes.worlds.schema import NamedPoseFile

START_RADIUS = 0.3  # [m] of free floor around a starting position that is searched


@dataclass(frozen=True)
class NamedPose:
    """A named pose, and the free space around it: lower and upper corner of a box along its axes [m]."""

    name: str
    description: str
    tags: tuple[str, ...]
    place: BodyState
    room: tuple[Vector, Vector] | None


def read_pose(
    pose: NamedPoseFile, index: int, extent: tuple[float, float, float, float], ground: Ground = FLAT
) -> NamedPose:
    """Read a named pose of a world file.

    Args:
        pose: Entry of the file.
        index: Index of the entry, from 0.
        extent: Extent of the map: lower x, y, upper x, y [m].

    Raises:
        FileError: The pose is outside of the world.
    """
    at, (left, bottom, right, top) = pose.pose, extent
    if not (left <= at.x <= right and bottom <= at.y <= top):
        raise FileError(
            f"poses.{index}.pose: {pose.name!r} at ({at.x:g}, {at.y:g}) is outside of the world; "
            f"expected a position from ({left:g}, {bottom:g}) to ({right:g}, {top:g})"
        )
    z = ground.height(at.x, at.y) if at.z is None else at.z
    place = BodyState((at.x, at.y, z), quaternion(at.roll, at.pitch, at.yaw))
    room = None if pose.bounds is None else (pose.bounds.lower, pose.bounds.upper)
    return NamedPose(pose.name, pose.description, pose.tags, place, room)


def free_start(known: NavigationMap, radius: float) -> Pose2:
    """Return the position nearest to the origin of `map` with free floor around it.

    Args:
        known: Map of the world.
        radius: Minimum distance to walls [m].

    Raises:
        FileError: The floor is occupied everywhere.
    """
    xs, ys = known.grid.centres()
    away = np.where(known.distance >= radius, np.hypot(xs, ys), np.inf)
    nearest = np.unravel_index(int(away.argmin()), away.shape)
    if not np.isfinite(away[nearest]):
        raise FileError(f"robots: no free floor with a radius of {radius:g} m; expected one for the pose `start`")
    return Pose2(round(float(xs[nearest]), 6), round(float(ys[nearest]), 6), 0.0)
