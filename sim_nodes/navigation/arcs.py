"""Free length of arcs among obstacle points, in closed form, for a round robot.

A robot of radius r on an arc about a centre C touches a point p where its distance to p is r. The distances of
both to C are constant along the arc, so the law of cosines has the angle (as in Fox, Burgard, Thrun 1997,
section III).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array
from sim_nodes.sensors.lidar import Scan

NEIGHBOURS = 4  # number of adjacent beams that must end at an obstacle to indicate one
STRAIGHT = 1e-3  # [1/m]; arcs of less curvature are straight
INSIDE = 1e-6  # [m] that a point inside of the circle is moved out


def solid_points(scan: Scan, reach: float) -> tuple[Array, Array]:
    """Return the points of obstacles within a distance of the base [m], in its frame, without stray beams.

    An obstacle stops all adjacent beams, noise only some. So ranges are closed (a maximum over adjacent beams,
    then a minimum), which lengthens beams that are alone.
    """
    hit = scan.hit
    ranges = scan.ranges[hit]
    count = len(ranges)
    if count < NEIGHBOURS:
        return np.zeros(0), np.zeros(0)
    around = ranges[np.arange(1 - NEIGHBOURS, count + NEIGHBOURS - 1) % count]
    size = count + NEIGHBOURS - 1
    most = around[:size].copy()
    for shift in range(1, NEIGHBOURS):
        np.maximum(most, around[shift : shift + size], out=most)
    closed = most[:count].copy()
    for shift in range(1, NEIGHBOURS):
        np.minimum(closed, most[shift : shift + count], out=closed)
    scale = closed / ranges
    mount = scan.mount
    x = mount.x + (scan.x[hit] - mount.x) * scale
    y = mount.y + (scan.y[hit] - mount.y) * scale
    near = x * x + y * y < reach * reach
    return x[near], y[near]


def free_lengths(curvatures: Array, x: Array, y: Array, radius: float, most: float) -> Array:
    """Return how far a round robot can drive forwards along arcs before it touches a point [m], shape (arcs,).

    A robot that is too close to a point already may move on, unless that brings it closer.

    Args:
        curvatures: Curvatures of the arcs, positive to the left [1/m], shape (arcs,).
        x: Points in the frame of the robot [m], shape (n,).
        y: See `x`.
        radius: Radius of the robot [m].
        most: Maximum of the result [m].
    """
    lengths = np.full(len(curvatures), most)
    if len(x) == 0:
        return lengths
    radii = np.minimum(radius, np.sqrt(x * x + y * y)) - INSIDE
    straight = np.abs(curvatures) < STRAIGHT
    if straight.any():
        lengths[straight] = min(most, _straight_length(x, y, radii))
    curved = np.flatnonzero(~straight)
    if len(curved):
        lengths[curved] = np.minimum(most, _curved_lengths(curvatures[curved], x, y, radii))
    return lengths


def _straight_length(x: Array, y: Array, radii: Array) -> float:
    ahead = (x > 0.0) & (np.abs(y) < radii)
    if not ahead.any():
        return np.inf
    r, side = radii[ahead], y[ahead]
    return float(np.maximum(x[ahead] - np.sqrt(r * r - side * side), 0.0).min())


def _curved_lengths(curvatures: Array, x: Array, y: Array, radii: Array) -> Array:
    turn = 1.0 / np.abs(curvatures)
    across = turn[:, None] - np.sign(curvatures)[:, None] * y
    squares = x * x + across * across  # of the distances to the centres
    nearest = np.maximum(turn[:, None] - radii, 0.0)
    arc: NDArray[np.int64]
    arc, point = np.nonzero((squares > nearest * nearest) & (squares < (turn[:, None] + radii) ** 2))
    lengths = np.full(len(curvatures), np.inf)
    if len(arc) == 0:
        return lengths
    r, big, d = radii[point], turn[arc], np.sqrt(squares[arc, point])
    cosine = (big * big + d * d - r * r) / np.maximum(2.0 * big * d, INSIDE)
    angle = np.arctan2(x[point], across[arc, point]) - np.arccos(cosine.clip(-1.0, 1.0))
    np.minimum.at(lengths, arc, big * (angle % (2.0 * np.pi)))
    return lengths


def arc_points(curvatures: Array, lengths: Array) -> tuple[Array, Array]:
    """Return the points x, y at some lengths along arcs from the origin along x [m]; shapes broadcast."""
    angle = curvatures * lengths
    chord = lengths * np.sinc(angle / (2.0 * np.pi))  # numpy's sinc is of pi times its argument
    return chord * np.cos(angle / 2.0), chord * np.sin(angle / 2.0)
