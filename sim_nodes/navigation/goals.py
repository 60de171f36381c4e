"""Navigation goals, their feedback, and the check of their poses on the map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.cover import Cover
from sim_nodes.navigation.grid_search import connected_cells
from sim_nodes.navigation.maps import Grid, NavigationMap
from sim_nodes.navigation.planner import ESCAPE_RADIUS
from sim_nodes.outcomes import operation_failed


@dataclass(frozen=True)
class Goal:
    """A navigation goal."""

    id: str
    poses: tuple[Pose2, ...]
    stop_at_each: bool
    feedback_period: float = 0.0  # [s]; 0 for no feedback


@dataclass(frozen=True)
class Feedback:
    """Progress of a goal, with the names of Nav2's feedback."""

    navigation_time: float  # [s] since the goal was accepted
    distance_remaining: float  # [m] along the plan, then straight between later poses
    estimated_time_remaining: float  # [s] at the average speed
    number_of_recoveries: int
    number_of_poses_remaining: int


def check_reachable(poses: tuple[Pose2, ...], start: Pose2, known: NavigationMap, cover: Cover) -> None:
    """Refuse poses that are invalid or unreachable on the map.

    Args:
        poses: Poses to drive through [m].
        start: Pose of the robot [m].
        known: The map.
        cover: Cover of the robot.

    Raises:
        RequestRefused: The message names the pose and the reason.
    """
    free = known.distance >= cover.room
    region = connected_cells(free, _cell_of_goal(poses[0], known, cover))
    is_near = bool(region[_cells_about(_core(start, cover), free, known.grid)].any())
    for pose in poses:
        if not (is_near and region[_cell_of_goal(pose, known, cover)]):
            raise operation_failed(
                f"goal ({pose.x:.2f}, {pose.y:.2f}) is unreachable on the map from ({start.x:.2f}, {start.y:.2f})"
            )


def _cell_of_goal(pose: Pose2, known: NavigationMap, cover: Cover) -> tuple[int, int]:
    """Return the cell of the core at a goal."""
    grid = known.grid
    where = f"goal ({pose.x:.2f}, {pose.y:.2f})"
    if not grid.contains(pose.x, pose.y):
        right, top = grid.x + grid.columns * grid.resolution, grid.y + grid.rows * grid.resolution
        raise operation_failed(
            f"{where} is outside of the map: x {grid.x:.2f} to {right:.2f} and y {grid.y:.2f} to {top:.2f}"
        )
    if not cover.is_round:
        gap = float(cover.gaps(grid, known.distance, np.array([pose]))[0])
        if gap < 0.0:
            raise operation_failed(
                f"{where} with a heading of {pose.yaw:.2f} rad is invalid: the outline of the robot, with its "
                f"margin, overlaps an obstacle of the map by {-gap:.2f} m; expected a free place"
            )
    core = _core(pose, cover)
    cell = grid.cell(core.x, core.y)
    room = float(known.distance[cell])
    if room < cover.room:
        place = "inside" if room == 0.0 else f"{room:.2f} m from"
        raise operation_failed(
            f"{where} is {place} an obstacle of the map; expected a clearance of {cover.room:.2f} m or more"
        )
    return cell


def _core(pose: Pose2, cover: Cover) -> Pose2:
    x, y, _ = cover.discs[0].tolist()
    return pose.compose(Pose2(x, y, 0.0))


def _cells_about(start: Pose2, free: NDArray[np.bool_], grid: Grid) -> tuple[slice, slice]:
    """Return the cells from which the way of a robot begins: its own, or those around it if that is closed."""
    column, row = grid.cell(start.x, start.y)
    reach = 0 if free[column, row] else round(ESCAPE_RADIUS / grid.resolution)
    return slice(max(column - reach, 0), column + reach + 1), slice(max(row - reach, 0), row + reach + 1)
