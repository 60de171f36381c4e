"""Terrain for the navigation of robots: where they can drive, and which returns of their lidars are ground."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import LidarDeclaration, MobileDeclaration
from sim_nodes.robots.drive_declaration import PlanarDrive
from sim_nodes.sensors.lidar import Scan
from sim_nodes.terrain.ground import Ground

SHARE_OF_WHEEL = 1.0 / 3.0  # of its radius, the height of a step that a wheel climbs
BASELINE = 3  # cells to both sides over which a slope is measured
MARGIN = 0.05  # [m] around terrain within which a return is from it

WithoutGround = Callable[[Scan], Scan]


class Surface:
    """The ground of a world, and the map of its walls.

    Args:
        ground: The ground.
        known: Map of the walls and other fixed things, which lidars see.
    """

    def __init__(self, ground: Ground, known: NavigationMap) -> None:
        self._ground, self.known = ground, known
        self._maps: dict[tuple[float, float], NavigationMap] = {}  # by maximum slope and step

    def passable(self, declaration: MobileDeclaration) -> NavigationMap:
        """Return the map of a base: terrain that is too steep or too high for it is an obstacle."""
        if self._ground.is_flat:
            return self.known
        slope, step = declaration.navigation.max_slope, _max_step(declaration)
        if (slope, step) not in self._maps:
            self._maps[slope, step] = _with_terrain(self.known, self._ground, slope, step)
        return self._maps[slope, step]

    def common(self, declarations: Iterable[MobileDeclaration]) -> NavigationMap:
        """Return the map in which terrain that none of some bases can pass is an obstacle."""
        maps = [self.passable(declaration) for declaration in declarations]
        if self._ground.is_flat or not maps:
            return self.known
        return replace(self.known, distance=np.maximum.reduce([each.distance for each in maps]))

    def without_ground(self, robot: str, lidar: LidarDeclaration, engine: Engine) -> WithoutGround | None:
        """Return a filter of scans that removes returns from the ground; None on a flat floor.

        Like a robot with an IMU and an elevation map, it knows the height and the attitude of the lidar.
        """
        if self._ground.is_flat:
            return None

        def filtered(scan: Scan) -> Scan:
            position, orientation = engine.link_pose(robot, lidar.link)
            angles = scan.angles - scan.mount.yaw
            beams = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
            beams = beams @ rotation_matrix(orientation).T
            reach = np.where(scan.hit, scan.ranges, 0.0)[:, None]
            ends, behind = (beams * (reach + further) + position for further in (0.0, MARGIN))
            heights = [self._ground.heights(points[:, 0], points[:, 1]) for points in (ends, behind)]
            is_ground = scan.hit & (ends[:, 2] < np.maximum(*heights) + MARGIN)
            ranges, x, y = (np.where(is_ground, np.inf, values) for values in (scan.ranges, scan.x, scan.y))
            return replace(scan, ranges=ranges, x=x, y=y)

        return filtered


def _max_step(declaration: MobileDeclaration) -> float:
    """Return the height of the highest step that a base passes [m]."""
    if declaration.navigation.max_step is not None:
        return declaration.navigation.max_step
    drive = declaration.drive
    radius = min(wheel.radius for wheel in drive.wheels) if isinstance(drive, PlanarDrive) else drive.wheel_radius
    return radius * SHARE_OF_WHEEL


def _with_terrain(known: NavigationMap, ground: Ground, slope: float, step: float) -> NavigationMap:
    """Return a map with obstacles where the ground is too steep or too high for a robot.

    Args:
        known: The map.
        ground: The ground.
        slope: Maximum slope [rad].
        step: Maximum height of a step [m].
    """
    blocked = impassable(ground, known, slope, step)
    if not blocked.any():
        return known
    from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - slow to load

    away: Array = distance_transform_edt(~blocked) * known.grid.resolution
    return NavigationMap(known.grid, np.minimum(known.distance, away))


def impassable(ground: Ground, known: NavigationMap, slope: float, step: float) -> NDArray[np.bool_]:
    """Return which cells of a map a robot cannot pass, shape (columns, rows).

    Between two cells, the ground may rise by the slope or by a step. A rise that the slope alone does not explain
    must also end soon: over a longer way, one step is allowed.
    """
    heights = ground.heights(*known.grid.centres())
    size, rise = known.grid.resolution, math.tan(slope)
    blocked = np.zeros(heights.shape, dtype=np.bool_)
    far = 2 * BASELINE
    for axis in (0, 1):
        turned, marked = np.moveaxis(heights, axis, 0), np.moveaxis(blocked, axis, 0)  # views
        change = np.abs(np.diff(turned, axis=0))
        high = change > max(step, rise * size)
        marked[:-1] |= high
        marked[1:] |= high
        if len(turned) <= far:
            continue
        long = np.abs(turned[far:] - turned[:-far]) > step + rise * far * size
        # A cell is on the slope if the ground also rises too much beside it.
        local = np.maximum(change[BASELINE - 1 : -BASELINE], change[BASELINE : len(change) - BASELINE + 1])
        marked[BASELINE:-BASELINE] |= long & (local > rise * size)
    return blocked
