"""Free length of arcs among obstacle points, in closed form, for round robots.

A robot of radius r on an arc about a centre C touches a point p where its distance to p is r. The distances of
both to C are constant along the arc, so the law of cosines has the angle (as in Fox, Burgard, Thrun 1997,
section III).

Functions take several robots at once, because most of the time of small arrays is that of calls. The numbers of a
robot do not depend on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Indices
from sim_nodes.sensors.lidar import Scan

NEIGHBOURS = 4  # number of adjacent beams that must end at an obstacle to indicate one
STRAIGHT = 1e-3  # [1/m]; arcs of less curvature are straight
INSIDE = 1e-6  # [m] that a point inside of the circle is moved out


@dataclass(frozen=True)
class Points:
    """Points around robots, each in the frame of its robot's base.

    Attributes:
        x: Coordinates of the points [m], shape (n,).
        y: See `x`.
        robot: Number of the robot of each point, shape (n,).
    """

    x: Array
    y: Array
    robot: Indices


def solid_points(scans: Sequence[Scan], reach: float) -> Points:
    """Return the points of obstacles within a distance of the base [m], without stray beams.

    An obstacle stops all adjacent beams, noise only some. So ranges are closed (a maximum over adjacent beams,
    then a minimum), which lengthens beams that are alone.

    Args:
        scans: The scan of each robot.
        reach: The distance [m].
    """
    seen = [_returns(scan) for scan in scans]
    ranges, x, y = (np.concatenate(values) for values in zip(*seen, strict=True))
    counts = np.array([len(each[0]) for each in seen])
    robot = np.repeat(np.arange(len(scans)), counts)
    mount_x, mount_y = np.array([scan.mount[:2] for scan in scans]).T[:, robot]
    scale = _closed(ranges, counts) / ranges
    x = mount_x + (x - mount_x) * scale
    y = mount_y + (y - mount_y) * scale
    near = x * x + y * y < reach * reach
    return Points(x[near], y[near], robot[near])


def _returns(scan: Scan) -> tuple[Array, Array, Array]:
    """Return ranges, x and y of the beams with a return, if they are enough to indicate an obstacle."""
    if scan.is_complete and len(scan.ranges) >= NEIGHBOURS:
        return scan.ranges, scan.x, scan.y
    hit = scan.hit if np.count_nonzero(scan.hit) >= NEIGHBOURS else np.zeros(len(scan.hit), dtype=np.bool_)
    return scan.ranges[hit], scan.x[hit], scan.y[hit]


def _closed(ranges: Array, counts: Indices) -> Array:
    """Return the closed ranges of turns of beams.

    Args:
        ranges: Ranges of all turns, one turn after the other, shape (n,) [m].
        counts: Number of beams of each turn.
    """
    most = int(counts.max())
    if most == 0:
        return ranges
    # Each turn is continued on both sides; a shorter one also goes on at the end.
    if int(counts.min()) == most:
        return _closed_turns(ranges.reshape(-1, most)[:, _steps_around(most)]).ravel()
    firsts, lengths = (np.cumsum(counts) - counts)[:, None], np.maximum(counts, 1)[:, None]
    around = ranges.take(_steps_around(most, ends=False) % lengths + firsts, mode="clip")  # clips empty turns only
    kept: Array = _closed_turns(around)[np.arange(most) < counts[:, None]]
    return kept


@lru_cache(maxsize=16)
def _steps_around(count: int, *, ends: bool = True) -> Indices:
    """Return the numbers of beams of a turn, from before its first one to after its last one.

    Args:
        count: Number of beams.
        ends: Whether the numbers begin again at the end of the turn.
    """
    steps = np.arange(1 - NEIGHBOURS, count + NEIGHBOURS - 1)
    return steps % count if ends else steps


def _closed_turns(around: Array) -> Array:
    """Return the closed ranges of turns that are continued on both sides, each in a row."""
    # Four neighbours are two pairs.
    pairs = np.maximum(around[:, :-1], around[:, 1:])
    longest = np.maximum(pairs[:, :-2], pairs[:, 2:])
    pairs = np.minimum(longest[:, :-1], longest[:, 1:])
    closed: Array = np.minimum(pairs[:, :-2], pairs[:, 2:])
    return closed


def free_lengths(curvatures: Array, points: Points, radius: float, most: float) -> Array:
    """Return how far round robots can drive forwards along arcs before they touch a point [m].

    A robot that is too close to a point already may move on, unless that brings it closer.

    Args:
        curvatures: Curvatures of the arcs, positive to the left [1/m], shape (robots, arcs).
        points: Points around the robots.
        radius: Radius of the robots [m].
        most: Maximum of the result [m].

    Returns:
        The lengths, shape (robots, arcs).
    """
    if len(points.x) == 0:
        return np.full(curvatures.shape, most)
    radii = np.minimum(radius, np.sqrt(points.x * points.x + points.y * points.y)) - INSIDE
    straight = np.abs(curvatures) < STRAIGHT
    lengths = np.where(
        straight,
        _straight_lengths(len(curvatures), points, radii)[:, None],
        _curved_lengths(np.where(straight, np.inf, curvatures), points, radii),
    )
    return np.minimum(lengths, most)


def _straight_lengths(robots: int, points: Points, radii: Array) -> Array:
    lengths = np.full(robots, np.inf)
    ahead = (points.x > 0.0) & (np.abs(points.y) < radii)
    r, side = radii[ahead], points.y[ahead]
    free = np.maximum(points.x[ahead] - np.sqrt(r * r - side * side), 0.0)
    np.minimum.at(lengths, points.robot[ahead], free)
    return lengths


def _curved_lengths(curvatures: Array, points: Points, radii: Array) -> Array:
    """Return the lengths of arcs that are not straight; arcs of infinite curvature touch nothing."""
    x, y, robot = points.x, points.y, points.robot
    turn = (1.0 / np.abs(curvatures))[robot]
    across = turn - np.sign(curvatures)[robot] * y[:, None]
    squares = (x * x)[:, None] + across * across  # of the distances to the centres
    nearest = np.maximum(turn - radii[:, None], 0.0)
    farthest = turn + radii[:, None]
    touches = (squares > nearest * nearest) & (squares < farthest * farthest) & (turn > 0.0)
    point, arc = np.nonzero(touches)
    r, big, d = radii[point], turn[point, arc], np.sqrt(squares[point, arc])
    cosine = (big * big + d * d - r * r) / np.maximum(2.0 * big * d, INSIDE)
    angle = np.arctan2(x[point], across[point, arc]) - np.arccos(cosine.clip(-1.0, 1.0))
    lengths = np.full(curvatures.size, np.inf)
    np.minimum.at(lengths, robot[point] * curvatures.shape[1] + arc, big * (angle % (2.0 * np.pi)))
    return lengths.reshape(curvatures.shape)


def arc_points(curvatures: Array, lengths: Array) -> tuple[Array, Array]:
    """Return the points x, y at some lengths along arcs from the origin along x [m]; shapes broadcast."""
    angle = curvatures * lengths
    chord = lengths * np.sinc(angle / (2.0 * np.pi))  # numpy's sinc is of pi times its argument
    return chord * np.cos(angle / 2.0), chord * np.sin(angle / 2.0)
