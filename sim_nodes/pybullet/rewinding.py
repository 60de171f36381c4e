"""The way back to states that Bullet has saved.

Bullet's `restoreState` puts back to the bit where bodies are, how they move and where they touch, if this is so:

- Between two links at most one pair of shapes is near enough to touch, since it takes one for all of them. Most
  links that move have one shape each (`shapes.py`). Where more meet, as in a corner of walls, or at an arm whose
  links have several, there is no way back (`meeting.py`).
- Motors are solved in the order in which they were made. Bullet sorts them by islands of bodies that may touch,
  whose order depends on the past, and mixes up those of one island by that. So all robots are in one island: gears
  without a force tie each to the next (`tie`).
- All is solved at once. Islands that are solved one by one are each iterated until they are accurate enough, and
  which bodies are in them depends on the past, too (`AT_ONCE`).
- Something touched in the saved state; otherwise Bullet leaves contacts as they are, and bounding boxes, by which
  rays find bodies. So everything is taken apart before then, and the boxes are renewed (`Saves.put_back`).

What is left out is what was told to motors, and what is to be seen of the step that led to the state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import pybullet

from sim_nodes.geometry import Array
from sim_nodes.journal import Mark
from sim_nodes.physics import TouchPoint
from sim_nodes.pybullet.arm import ArmCommand
from sim_nodes.pybullet.drive import DriveCommand

APART = 1000.0  # [m] between bodies that touch nothing
AT_ONCE = 1_000_000_000  # constraints that Bullet waits for before it solves those of an island


@dataclass(frozen=True)
class LastStep:
    """What is to be seen of the step that led to a state, besides the state.

    Attributes:
        touching: The pairs of entities in contact.
        points: Where robots touched others.
        links: What the links of arms touched.
        efforts: Of the motors of arms [N m], [N].
    """

    touching: frozenset[tuple[str, str]]
    points: Mapping[str, tuple[TouchPoint, ...]]
    links: Mapping[str, frozenset[tuple[str, str]]]
    efforts: Mapping[str, Array]


@dataclass(frozen=True)
class Checkpoint:
    """A state to go back to.

    Attributes:
        saved: What Bullet has saved.
        mark: How it has come to this.
        drives: What wheels were told.
        arms: What arms were told.
        last: What is to be seen of the last step.
    """

    saved: Saved
    mark: Mark
    drives: Mapping[str, DriveCommand]
    arms: Mapping[str, ArmCommand]
    last: LastStep


class Saved:
    """A state that Bullet has saved, by its number, which a later one may have; and whether anything touched."""

    def __init__(self, number: int, *, touched: bool) -> None:
        self.number, self.touched = number, touched


class Saves:
    """Has Bullet save states, of which it keeps the last.

    Args:
        bullet: Bullet, with a scene that was just loaded.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._last: Saved | None = None

    def take(self) -> Saved:
        """Save the state."""
        if self._last is not None:
            self._bullet.removeState(self._last.number)
        self._last = Saved(self._bullet.saveState(), touched=bool(self._bullet.getContactPoints()))
        return self._last

    def has(self, saved: Saved) -> bool:
        """Whether a state is the last that was saved of this scene."""
        return saved is self._last

    def put_back(self, saved: Saved, bodies: Sequence[int]) -> None:
        """Be in a state again, with these bodies, and others that never move."""
        bullet = self._bullet
        if not saved.touched:
            for place, body in enumerate(bodies):
                bullet.resetBasePositionAndOrientation(body, (APART * place, 0.0, APART), (0.0, 0.0, 0.0, 1.0))
            bullet.performCollisionDetection()
        bullet.restoreState(saved.number)
        for body in bodies:
            bullet.resetBaseVelocity(body, *bullet.getBaseVelocity(body))  # which renews its boxes


def tie(bullet: Any, joints: Mapping[int, int]) -> None:
    """Tie robots together without any force, the body of each by one of its joints."""
    for (first, joint), (second, other) in pairwise(joints.items()):
        gear = bullet.createConstraint(
            first, joint, second, other, pybullet.JOINT_GEAR, [1, 0, 0], [0, 0, 0], [0, 0, 0]
        )
        bullet.changeConstraint(gear, gearRatio=-1, maxForce=0.0)
