"""Neighbourhood of agents: positions and velocities of all others, and the nearest walls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array


@dataclass(frozen=True)
class Neighbourhood:
    """Agents with one way to avoid others, and all others around them.

    Attributes:
        positions: Positions of these agents, shape (n, 2) [m].
        velocities: Their velocities, shape (n, 2) [m/s].
        radii: Their radii, shape (n,) [m].
        wall_distances: Distances to the nearest wall, shape (n,) [m].
        away: Directions away from it, shape (n, 2).
        other_positions: Positions of all agents and robots, shape (m, 2) [m].
        other_velocities: Their velocities, shape (m, 2) [m/s].
        other_radii: Their radii, shape (m,) [m].
        is_self: Pairs of an agent and itself, shape (n, m).
    """

    positions: Array
    velocities: Array
    radii: Array
    wall_distances: Array
    away: Array
    other_positions: Array
    other_velocities: Array
    other_radii: Array
    is_self: NDArray[np.bool_]

    def of(self, chosen: NDArray[np.bool_]) -> Neighbourhood:
        """Return the neighbourhood of some of these agents, given as a mask of shape (n,)."""
        if chosen.all():
            return self
        return Neighbourhood(
            self.positions[chosen],
            self.velocities[chosen],
            self.radii[chosen],
            self.wall_distances[chosen],
            self.away[chosen],
            self.other_positions,
            self.other_velocities,
            self.other_radii,
            self.is_self[chosen],
        )
