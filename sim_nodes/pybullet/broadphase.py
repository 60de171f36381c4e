"""Broad phase: finds shapes that may touch, by their bounding boxes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim_nodes.extents import bounding_box
from sim_nodes.geometry import Array, Quaternion, Vector, conjugate, multiply, rotated, vector
from sim_nodes.physics import BodyState, Part
from sim_nodes.pybullet.model import BASE, wxyz

NEAR = 0.05  # [m] between bounding boxes; covers a relative speed of 10 m/s in one step
FLOOR_BOX = np.array([[[-np.inf, -np.inf, -np.inf], [np.inf, np.inf, 0.0]]])
NO_BODY = -1  # body number of the floor

Parts = tuple[Part, ...]


@dataclass(frozen=True)
class Collider:
    """A link with its shapes, the unit of Bullet's contact search.

    Attributes:
        body: Number of its body, whose links do not touch each other.
        moves: Whether it may move.
        boxes: Bounding boxes of its shapes in `map`, lower and upper corners, shape (n, 2, 3) [m].
    """

    body: int
    moves: bool
    boxes: Array


class BroadPhase:
    """The colliders of a world.

    Args:
        bullet: The Bullet client.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._standing: dict[int, Collider] = {}
        self._moving: dict[int, tuple[Mapping[int, Parts], bool]] = {}

    def add_static(self, body: int, parts: Parts, state: BodyState) -> None:
        """Add a static body of one link."""
        self._standing[body] = Collider(body, False, _boxes(parts, state.position, state.orientation))

    def add_moving(self, body: int, wide: Mapping[int, Parts], *, fixed: bool = False) -> None:
        """Add a body that moves, or whose links do if its base is fixed, with its links of several shapes."""
        self._moving[body] = (wide, fixed)

    def remove(self, body: int) -> None:
        """Remove a body."""
        self._standing.pop(body, None)
        self._moving.pop(body, None)

    def has_ambiguous_pair(self) -> bool:
        """Whether more than one pair of shapes of any two links may touch."""
        colliders = tuple(self._colliders())
        boxes = np.concatenate([each.boxes for each in colliders])
        owners = np.repeat(np.arange(len(colliders)), [len(each.boxes) for each in colliders])
        for each in colliders:
            if len(each.boxes) > 1:
                lower, upper = each.boxes[:, None, 0] - NEAR, each.boxes[:, None, 1] + NEAR
                near = ((lower <= boxes[:, 1]) & (boxes[:, 0] <= upper)).all(axis=2).sum(axis=0)
                met = (np.bincount(owners, near) > 1).nonzero()[0].tolist()
                if any(_may_touch(each, colliders[index]) for index in met):
                    return True
        return False

    def _colliders(self) -> Iterator[Collider]:
        yield Collider(NO_BODY, False, FLOOR_BOX)
        yield from self._standing.values()
        for body, (wide, fixed) in self._moving.items():
            for link in range(BASE, self._bullet.getNumJoints(body)):
                if link in wide:
                    boxes = _boxes(wide[link], *_frame(self._bullet, body, link))
                else:
                    boxes = np.array([self._bullet.getAABB(body, link)])
                yield Collider(body, link != BASE or not fixed, boxes)


def _frame(bullet: Any, body: int, link: int) -> tuple[Vector, Quaternion]:
    """Return the pose of a link's frame."""
    if link != BASE:
        found = bullet.getLinkState(body, link, computeForwardKinematics=True)
        return found[4], wxyz(found[5])
    place, turn = bullet.getBasePositionAndOrientation(body)
    centre, axes = bullet.getDynamicsInfo(body, BASE)[3:5]
    orientation = multiply(wxyz(turn), conjugate(wxyz(axes)))
    return vector(np.subtract(place, rotated(orientation, centre))), orientation


def _may_touch(first: Collider, second: Collider) -> bool:
    return first.body != second.body and (first.moves or second.moves)


def _boxes(parts: Iterable[Part], position: Vector, orientation: Quaternion) -> Array:
    boxes = []
    for part in parts:
        centre = vector(np.add(position, rotated(orientation, part.position)))
        box = bounding_box([Part(part.shape, centre, multiply(orientation, part.orientation))])
        assert box is not None
        boxes.append((box.lower, box.upper))
    return np.array(boxes)
