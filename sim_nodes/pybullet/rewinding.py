"""Restores states that Bullet has saved.

Bullet's `restoreState` is bit-exact for poses, velocities and contacts under these conditions:

- Between two links, at most one pair of shapes is close enough to touch, because Bullet restores one per pair of
  links. Most moving links have one shape (`shapes.py`). Otherwise, as in a corner of walls or for arms, no
  checkpoint is possible (`broadphase.py`).
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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import pybullet

from sim_nodes.geometry import Array
from sim_nodes.journal import Mark
from sim_nodes.physics import ContactPoint
from sim_nodes.pybullet.arm import ArmCommand
from sim_nodes.pybullet.drive import DriveCommand

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
    """

    saved: Saved
    mark: Mark
    drives: Mapping[str, DriveCommand]
    arms: Mapping[str, ArmCommand]
    last: LastStep


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
