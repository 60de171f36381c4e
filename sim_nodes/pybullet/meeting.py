"""Which shapes are so near to one another that they may touch, by their bounding boxes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim_nodes.bounds import bounding_box
from sim_nodes.geometry import Array, Quaternion, Vector, conjugate, multiply, rotated
from sim_nodes.physics import BodyState, Part
from sim_nodes.pybullet.model import BASE, wxyz

NEAR = 0.05  # [m] between bounding boxes: what has touched in the step before and moves at 10 m/s is not beyond it
FLOOR_BOX = np.array([[[-np.inf, -np.inf, -np.inf], [np.inf, np.inf, 0.0]]])
NO_BODY = -1  # of the floor here

Parts = tuple[Part, ...]


@dataclass(frozen=True)
class Collider:
    """What Bullet takes for one when it looks for contacts: a link with its shapes.

    Attributes:
        body: Number of its body, whose links do not touch each other.
        moves: Whether it may move.
        boxes: Bounding boxes of its shapes in the map, lower and upper corners, shape (n, 2, 3) [m].
    """

    body: int
    moves: bool
    boxes: Array


class Meeting:
    """What may meet in a world.

    Args:
        bullet: Bullet.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._standing: dict[int, Collider] = {}
        self._moving: dict[int, tuple[Mapping[int, Parts], bool]] = {}

    def stand(self, body: int, parts: Parts, state: BodyState) -> None:
        """Take note of where a body of one link stands fixed."""
        self._standing[body] = Collider(body, False, _boxes(parts, state.position, state.orientation))

    def move(self, body: int, wide: Mapping[int, Parts], *, fixed: bool = False) -> None:
        """Take note of a body that moves, or but its base if that is fixed, and of its links of several shapes."""
        self._moving[body] = (wide, fixed)

    def remove(self, body: int) -> None:
        """Forget a body."""
        self._standing.pop(body, None)
        self._moving.pop(body, None)

    def is_twice(self) -> bool:
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
    """Where the frame of a link is."""
    if link != BASE:
        found = bullet.getLinkState(body, link, computeForwardKinematics=True)
        return found[4], wxyz(found[5])
    place, turn = bullet.getBasePositionAndOrientation(body)
    centre, axes = bullet.getDynamicsInfo(body, BASE)[3:5]
    orientation = multiply(wxyz(turn), conjugate(wxyz(axes)))
    x, y, z = np.subtract(place, rotated(orientation, centre)).tolist()
    return (x, y, z), orientation


def _may_touch(first: Collider, second: Collider) -> bool:
    return first.body != second.body and (first.moves or second.moves)


def _boxes(parts: Iterable[Part], position: Vector, orientation: Quaternion) -> Array:
    boxes = []
    for part in parts:
        x, y, z = np.add(position, rotated(orientation, part.position)).tolist()
        box = bounding_box([Part(part.shape, (x, y, z), multiply(orientation, part.orientation))])
        assert box is not None
        boxes.append((box.lower, box.upper))
    return np.array(boxes)
