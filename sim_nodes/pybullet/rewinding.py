"""Restores states that Bullet has saved.

Bullet's `restoreState` is bit-exact for poses, velocities and contacts under these conditions:

- Between two links, at most one pair of shapes is close enough to touch, because Bullet restores one per pair of
  links. Most moving links have one shape (`split_links`). Otherwise, as in a corner of walls or for arms, no
  checkpoint is possible (`BroadPhase`).
- Motors are solved in the order of their creation. Bullet sorts them by islands of bodies that may touch; the
  order of islands depends on the past, and changes that within an island. So all robots are in one island: gears
  without force connect each to the next (`join_islands`).
- All constraints are solved at once. Islands solved separately iterate until each is accurate enough, and their
  members depend on the past as well (`AT_ONCE`).
- Something touched in the saved state. Otherwise Bullet keeps present contacts, and the bounding boxes used by
  rays. So bodies are moved apart first, and the boxes are updated (`StateStore.restore`).

Motor commands and the results of the last step are not part of Bullet's state.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pybullet

from seoro.deferred import dataclass
from sim_nodes.extents import box_around
from sim_nodes.geometry import Array, Quaternion, Vector
from sim_nodes.journal import Mark
from sim_nodes.physics import BodyState, ContactPoint, Part
from sim_nodes.pybullet.drives import DriveCommand
from sim_nodes.pybullet.joints import ArmCommand
from sim_nodes.pybullet.model import BASE, link_frame
from sim_nodes.pybullet.work import WorkDone

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
        self._ignored: dict[int, frozenset[int]] = {}  # bodies that a body passes through

    def add_static(self, body: int, parts: Parts, state: BodyState) -> None:
        """Add a static body of one link."""
        self._standing[body] = Collider(body, False, _boxes(parts, state.position, state.orientation))

    def add_moving(self, body: int, compound: Mapping[int, Parts], *, fixed: bool = False) -> None:
        """Add a body that moves, or whose links do if its base is fixed, with its links of several shapes."""
        self._moving[body] = (compound, fixed)

    def ignore(self, body: int, others: Iterable[int]) -> None:
        """Ignore contacts of a body with others, which it passes through, and with the floor."""
        self._ignored[body] = frozenset((*others, NO_BODY))

    def remove(self, body: int) -> None:
        """Remove a body."""
        self._ignored.pop(body, None)
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
                if any(self._may_touch(each, colliders[index]) for index in met):
                    return True
        return False

    def _may_touch(self, first: Collider, second: Collider) -> bool:
        if first.body == second.body or not (first.moves or second.moves):
            return False
        pairs = ((first.body, second.body), (second.body, first.body))
        return not any(other in self._ignored.get(body, ()) for body, other in pairs)

    def _colliders(self) -> Iterator[Collider]:
        yield Collider(NO_BODY, False, FLOOR_BOX)
        yield from self._standing.values()
        for body, (compound, fixed) in self._moving.items():
            for link in range(BASE, self._bullet.getNumJoints(body)):
                if link in compound:
                    boxes = _boxes(compound[link], *link_frame(self._bullet, body, link))
                else:
                    boxes = np.array([self._bullet.getAABB(body, link)])
                yield Collider(body, link != BASE or not fixed, boxes)


def _boxes(parts: Iterable[Part], position: Vector, orientation: Quaternion) -> Array:
    boxes = [box_around(part.placed(position, orientation)) for part in parts]
    return np.array([(box.lower, box.upper) for box in boxes])


APART = 1000.0  # [m] between bodies without contacts
AT_ONCE = 1_000_000_000  # number of constraints that Bullet collects before it solves an island


@dataclass(frozen=True)
class LastStep:
    """Results of the last step, beyond the state.

    Attributes:
        touching: Pairs of entities in contact.
        points: Contact points of robots.
        links: Contacts of the links of arms.
        efforts: Efforts of the motors of arms [N m], [N].
    """

    touching: frozenset[tuple[str, str]]
    points: Mapping[str, tuple[ContactPoint, ...]]
    links: Mapping[str, frozenset[tuple[str, str]]]
    efforts: Mapping[str, Array]


@dataclass(frozen=True)
class Checkpoint:
    """A state to return to.

    Attributes:
        saved: State saved by Bullet.
        mark: Position in the journal.
        drives: Commands of wheels.
        arms: Commands of arms.
        last: Results of the last step.
        work: Work of motors.
    """

    saved: Saved
    mark: Mark
    drives: Mapping[str, DriveCommand]
    arms: Mapping[str, ArmCommand]
    last: LastStep
    work: WorkDone


class Saved:
    """A state saved by Bullet: its number, which may be reused, and whether anything touched."""

    def __init__(self, number: int, *, touched: bool) -> None:
        self.number, self.touched = number, touched


class StateStore:
    """States saved by Bullet, of which the last is kept.

    Args:
        bullet: The Bullet client, with a newly loaded scene.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._last: Saved | None = None

    def save(self) -> Saved:
        """Save the state."""
        if self._last is not None:
            self._bullet.removeState(self._last.number)
        self._last = Saved(self._bullet.saveState(), touched=bool(self._bullet.getContactPoints()))
        return self._last

    def is_latest(self, saved: Saved) -> bool:
        """Whether a state is the last one saved of this scene."""
        return saved is self._last

    def restore(self, saved: Saved, bodies: Sequence[int]) -> None:
        """Restore a state of these bodies; all others never move."""
        bullet = self._bullet
        if not saved.touched:
            for place, body in enumerate(bodies):
                bullet.resetBasePositionAndOrientation(body, (APART * place, 0.0, APART), (0.0, 0.0, 0.0, 1.0))
            bullet.performCollisionDetection()
        bullet.restoreState(saved.number)
        for body in bodies:
            bullet.resetBaseVelocity(body, *bullet.getBaseVelocity(body))  # updates its bounding boxes


def join_islands(bullet: Any, joints: Mapping[int, int]) -> None:
    """Connect robots by constraints without force, each by one of its joints."""
    for (first, joint), (second, other) in pairwise(joints.items()):
        gear = bullet.createConstraint(
            first, joint, second, other, pybullet.JOINT_GEAR, [1, 0, 0], [0, 0, 0], [0, 0, 0]
        )
        bullet.changeConstraint(gear, gearRatio=-1, maxForce=0.0)
