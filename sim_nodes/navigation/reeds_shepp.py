"""Shortest paths of a car that drives both ways, for many pairs of poses at once.

J. A. Reeds and L. A. Shepp (1990): "Optimal paths for a car that goes both forwards and backwards", section 8.
Their equations 8.1 to 8.11 have the lengths of the pieces of eight families; reversing time, reflecting and
reversing the order of a family give all 48 words. All lengths are in turning radii.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, wrap

EXACT = 1e-6  # of the end of a word, in turning radii and radians
HALF_PI = np.pi / 2.0

Pieces = tuple[Array | float, ...]
Family = Callable[[Array, Array, Array], Pieces]
"""Returns the signed lengths of the pieces for the end x, y, yaw; NaN without a solution."""


@dataclass(frozen=True)
class Words:
    """The best word for each pair of poses.

    Attributes:
        lengths: Signed lengths of up to five pieces, negative backwards, shape (n, 5) [turning radii].
        turns: Curvature of each piece: 1 to the left, -1 to the right, 0 straight, shape (n, 5).
        costs: Weighted lengths, shape (n,) [turning radii].
    """

    lengths: Array
    turns: Array
    costs: Array


def shortest_words(ends: Array, reverse_penalty: float) -> Words:
    """Return the cheapest words from the origin to poses.

    Args:
        ends: Poses (x [turning radii], y, yaw [rad]), shape (n, 3).
        reverse_penalty: Cost of a length backwards, relative to that forwards.
    """
    x, y, yaw = _variants(ends)
    found_lengths, found_turns = [], []
    with np.errstate(invalid="ignore"):
        for family, turns in FAMILIES:
            pieces = np.stack(np.broadcast_arrays(*family(x, y, yaw)), axis=-1)
            lengths = np.zeros((*pieces.shape[:-1], 5))
            lengths[..., : pieces.shape[-1]] = pieces
            found_lengths.append(lengths)
            found_turns.append((*turns, *(0.0,) * (5 - len(turns))))
    lengths, curvatures = _undo(np.array(found_lengths), np.array(found_turns))
    reached = _ends(lengths, curvatures)
    off = np.abs(reached[..., :2] - ends[:, :2]).max(axis=-1) + np.abs(wrap(reached[..., 2] - ends[:, 2]))
    costs = np.where(lengths < 0.0, -reverse_penalty, 1.0) * lengths
    costs = np.where(off < EXACT, costs.sum(axis=-1), np.inf)
    best = costs.argmin(axis=0)
    each = np.arange(len(ends))
    return Words(lengths[best, each], curvatures[best, each], costs[best, each])


def _variants(ends: Array) -> tuple[Array, Array, Array]:
    """Return the ends of the problems that are equal but for time, side and order, each of shape (8, n)."""
    x, y, yaw = ends.T
    cos, sin = np.cos(yaw), np.sin(yaw)
    reversed_x, reversed_y = x * cos + y * sin, x * sin - y * cos  # of the path driven from its end
    ahead = np.array([x, x, reversed_x, reversed_x])
    left = np.array([y, -y, reversed_y, -reversed_y])
    turn = np.array([yaw, -yaw, yaw, -yaw])
    return np.vstack([ahead, -ahead]), np.vstack([left, left]), np.vstack([turn, -turn])


def _undo(lengths: Array, turns: Array) -> tuple[Array, Array]:
    """Return the words of all variants as those of the problem itself, shapes (words, n, 5).

    Args:
        lengths: Lengths of the pieces, shape (families, 8, n, 5).
        turns: Curvatures of the families, shape (families, 5).
    """
    all_turns = np.broadcast_to(turns[:, None, None, :], lengths.shape).copy()
    lengths[:, 4:] *= -1.0
    all_turns[:, 1::2] *= -1.0
    for backwards in (slice(2, 4), slice(6, 8)):
        lengths[:, backwards] = lengths[:, backwards, :, ::-1]
        all_turns[:, backwards] = all_turns[:, backwards, :, ::-1]
    count = lengths.shape[2]
    return lengths.reshape(-1, count, 5), all_turns.reshape(-1, count, 5)


def _ends(lengths: Array, turns: Array) -> Array:
    """Return the poses to which words lead from the origin, shape (..., 3)."""
    x = y = yaw = np.zeros(lengths.shape[:-1])
    for piece in range(lengths.shape[-1]):
        dx, dy, turn = arc_motion(lengths[..., piece], turns[..., piece])
        cos, sin = np.cos(yaw), np.sin(yaw)
        x, y, yaw = x + cos * dx - sin * dy, y + sin * dx + cos * dy, yaw + turn
    return np.stack([x, y, yaw], axis=-1)


def arc_motion(length: Array, curvature: Array) -> tuple[Array, Array, Array]:
    """Return the motion x, y, yaw along arcs of signed lengths; shapes broadcast."""
    turn = curvature * length
    chord = length * np.sinc(turn / (2.0 * np.pi))  # numpy's sinc is of pi times its argument
    return chord * np.cos(turn / 2.0), chord * np.sin(turn / 2.0), turn


# ------------------------------------------------------------ families, for turns as in `FAMILIES`


def _polar(x: Array, y: Array) -> tuple[Array, Array]:
    return np.hypot(x, y), np.arctan2(y, x)


def _same(x: Array, y: Array, yaw: Array) -> tuple[Array, Array]:
    return x - np.sin(yaw), y - 1.0 + np.cos(yaw)


def _other(x: Array, y: Array, yaw: Array) -> tuple[Array, Array]:
    return x + np.sin(yaw), y - 1.0 - np.cos(yaw)


def _lsl(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equation 8.1."""
    u, t = _polar(*_same(x, y, yaw))
    return wrap(t), u, wrap(yaw - t)


def _lsr(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equation 8.2."""
    r, angle = _polar(*_other(x, y, yaw))
    u = np.sqrt(r * r - 4.0)
    t = wrap(angle + np.arctan2(2.0, u))
    return t, u, wrap(t - yaw)


def _lrl(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equations 8.3 and 8.4."""
    r, angle = _polar(*_same(x, y, yaw))
    u = -2.0 * np.arcsin(r / 4.0)
    t = wrap(angle + u / 2.0 + np.pi)
    return t, u, wrap(yaw - t + u)


def _first_and_last(u: Array, v: Array, xi: Array, eta: Array, yaw: Array) -> tuple[Array, Array]:
    """Return the lengths of the first and last piece of four (equations 8.5 and 8.6)."""
    delta = u - v
    a, b = np.sin(u) - np.sin(delta), np.cos(u) - np.cos(delta) - 1.0
    angle = np.arctan2(eta * a - xi * b, xi * a + eta * b)
    flipped = 2.0 * (np.cos(delta) - np.cos(v) - np.cos(u)) + 3.0 < 0.0
    t = wrap(np.where(flipped, angle + np.pi, angle))
    return t, wrap(t - u + v - yaw)


def _lrlr_inner(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equation 8.7."""
    xi, eta = _other(x, y, yaw)
    u = np.arccos((2.0 + np.hypot(xi, eta)) / 4.0)
    t, v = _first_and_last(u, -u, xi, eta, yaw)
    return t, u, -u, v


def _lrlr_outer(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equation 8.8."""
    xi, eta = _other(x, y, yaw)
    u = -np.arccos((20.0 - xi * xi - eta * eta) / 16.0)
    t, v = _first_and_last(u, u, xi, eta, yaw)
    return t, u, u, v


def _lrsl(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equation 8.9."""
    r, angle = _polar(*_same(x, y, yaw))
    side = np.sqrt(r * r - 4.0)
    t = wrap(angle + np.arctan2(side, -2.0))
    return t, -HALF_PI, 2.0 - side, wrap(yaw - HALF_PI - t)


def _lrsr(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equation 8.10."""
    xi, eta = _other(x, y, yaw)
    r, t = _polar(-eta, xi)
    return t, -HALF_PI, 2.0 - r, wrap(t + HALF_PI - yaw)


def _lrslr(x: Array, y: Array, yaw: Array) -> Pieces:
    """Equation 8.11."""
    xi, eta = _other(x, y, yaw)
    u = 4.0 - np.sqrt(xi * xi + eta * eta - 4.0)
    t = wrap(np.arctan2((4.0 - u) * xi - 2.0 * eta, -2.0 * xi + (u - 4.0) * eta))
    return t, -HALF_PI, u, -HALF_PI, wrap(t - yaw)


FAMILIES: tuple[tuple[Family, tuple[float, ...]], ...] = (
    (_lsl, (1.0, 0.0, 1.0)),
    (_lsr, (1.0, 0.0, -1.0)),
    (_lrl, (1.0, -1.0, 1.0)),
    (_lrlr_inner, (1.0, -1.0, 1.0, -1.0)),
    (_lrlr_outer, (1.0, -1.0, 1.0, -1.0)),
    (_lrsl, (1.0, -1.0, 0.0, 1.0)),
    (_lrsr, (1.0, -1.0, 0.0, -1.0)),
    (_lrslr, (1.0, -1.0, 0.0, 1.0, -1.0)),
)
