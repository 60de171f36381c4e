"""Built-in bodies in PyBullet, such as doors: they have no weight, and pass through walls and the floor."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pybullet

from sim_nodes.pybullet.model import BASE


class Weightless:
    """Forces that balance the weight of bodies.

    Args:
        client: Number of the connection.
        gravity: Acceleration of gravity [m/s^2].
    """

    def __init__(self, client: int, gravity: float) -> None:
        self._client, self._gravity = client, gravity
        self._lifts: dict[int, tuple[float, float, float]] = {}  # force by body [N]

    def add(self, body: int, mass: float) -> None:
        """Balance the weight of a body with a mass [kg]."""
        self._lifts[body] = (0.0, 0.0, mass * self._gravity)

    def remove(self, body: int) -> None:
        """Forget a body."""
        self._lifts.pop(body, None)

    def apply(self) -> None:
        """Apply the forces of one step; Bullet removes them after it."""
        for body, force in self._lifts.items():
            centre, _ = pybullet.getBasePositionAndOrientation(body, self._client)
            pybullet.applyExternalForce(
                body, BASE, force, centre, pybullet.WORLD_FRAME, physicsClientId=self._client
            )


def pass_through(bullet: Any, body: int, others: Iterable[int], *, passes: bool = True) -> None:
    """Let a body of one link pass through other bodies of one link, or not; Bullet reuses numbers of bodies."""
    for other in others:
        bullet.setCollisionFilterPair(body, other, BASE, BASE, int(not passes))
