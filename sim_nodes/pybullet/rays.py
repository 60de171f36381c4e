"""Rays of robots, which pass through the robot that casts them.

Each robot has a collision group, by which its rays ignore it. Large worlds have fewer groups than robots: a robot
that shares its group also searches all hits in it for those of others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np
import pybullet

from sim_nodes.geometry import Array, Vector

FIRST_GROUP = 8  # bit of the first group of robots; Bullet uses those below
GROUPS = 23  # of robots; a group is a signed number of 32 bits
ALL_GROUPS = -1
MOST_RAYS = pybullet.MAX_RAY_INTERSECTION_BATCH_SIZE  # of one call
Hit = tuple[int, float]  # number of a body, negative for none; distance as a share of the length of the ray


class Rays:
    """Casts the rays of all robots.

    Args:
        bullet: The Bullet client, with a new world.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._bodies: dict[str, int] = {}
        self._groups: dict[str, int] = {}
        self._members: Counter[int] = Counter()

    def add(self, robot: str, body: int, links: Iterable[int]) -> None:
        """Add a robot by the numbers of its body and of its links."""
        group = 1 << (FIRST_GROUP + len(self._bodies) % GROUPS)
        self._bodies[robot], self._groups[robot] = body, group
        self._members[group] += 1
        for link in links:
            self._bullet.setCollisionFilterGroupMask(body, link, group, ALL_GROUPS)

    def cast(self, robot: str, origin: Vector, ends: Array) -> Array:
        """Cast rays of a robot.

        Args:
            robot: Name of the robot.
            origin: Point at which all rays begin, in `map` [m].
            ends: Points at which they end, in `map`, shape (n, 3) [m].

        Returns:
            Distances of the first hits as shares of the lengths of the rays, shape (n,); infinite without a hit.
        """
        group = self._groups[robot]
        found = _shares(self._hits(origin, ends, ALL_GROUPS & ~group))
        return found if self._members[group] == 1 else np.minimum(found, self._others(robot, origin, ends))

    def _others(self, robot: str, origin: Vector, ends: Array) -> Array:
        """Return the shares of the first hits of other robots in the same group; see `cast`."""
        nearest, left, number = np.full(len(ends), np.inf), np.arange(len(ends)), 0
        while len(left):
            hits = self._hits(origin, ends[left], self._groups[robot], number)
            others = [(body if body != self._bodies[robot] else -1, share) for body, share in hits]
            nearest[left] = np.minimum(nearest[left], _shares(others))
            left, number = left[[body >= 0 for body, _ in hits]], number + 1
        return nearest

    def _hits(self, origin: Vector, ends: Array, mask: int, number: int | None = None) -> list[Hit]:
        """Return the nearest hits of some groups, or the ones of a number, in no order."""
        options = {} if number is None else {"reportHitNumber": number}
        starts, stops = [list(origin)] * len(ends), ends.tolist()
        hits: list[Hit] = []
        for first in range(0, len(ends), MOST_RAYS):
            some = slice(first, first + MOST_RAYS)
            batch = self._bullet.rayTestBatch(starts[some], stops[some], collisionFilterMask=mask, **options)
            hits += [(hit[0], hit[2]) for hit in batch]
        return hits


def _shares(hits: list[Hit]) -> Array:
    return np.array([share if body >= 0 else np.inf for body, share in hits])
