"""Optimal reciprocal collision avoidance of van den Berg et al. (ISRR 2009), by the library pyrvo.

All others are expected to do half of the avoiding. A new simulator of the library in each tick makes the result a
function of the neighbourhood alone. Its obstacles exclude walls, before which all agents stop (`stopping.py`).
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.agents.neighbourhood import Neighbourhood
from sim_nodes.geometry import Array

NEIGHBOUR_DISTANCE, NEIGHBOURS = 5.0, 10  # [m], number of considered neighbours
HORIZON = 2.0  # [s] that velocities keep free of collisions
FASTEST = 1.3  # maximum speed, as a share of the wanted one
GAP = 0.05  # [m] added to each radius
SIDESTEP = 1e-3  # [rad] turn of wanted velocities, which decides between equal sides


def velocities_after(around: Neighbourhood, wanted: Array, duration: float) -> Array:
    """Return the velocities of people after a duration [s], shape (n, 2) [m/s].

    Args:
        around: The people and their neighbourhood.
        wanted: Wanted velocities, shape (n, 2) [m/s].
        duration: Duration [s].
    """
    import pyrvo  # noqa: PLC0415 - optional, for people with this model

    solver = pyrvo.RVOSimulator(duration, NEIGHBOUR_DISTANCE, NEIGHBOURS, HORIZON, HORIZON, 0.0, 0.0)
    preferred = around.other_velocities.copy()
    cos, sin = math.cos(SIDESTEP), math.sin(SIDESTEP)
    turned = wanted @ np.array([(cos, -sin), (sin, cos)])
    own = around.is_self.argmax(axis=1)
    preferred[own] = turned
    speeds = np.hypot(preferred[:, 0], preferred[:, 1])
    rows = zip(around.other_positions.tolist(), around.other_velocities.tolist(), preferred.tolist(), strict=True)
    for index, (place, velocity, goal) in enumerate(rows):
        solver.add_agent(tuple(place))
        solver.set_agent_radius(index, float(around.other_radii[index]) + GAP)
        solver.set_agent_max_speed(index, FASTEST * float(speeds[index]))
        solver.set_agent_velocity(index, tuple(velocity))
        solver.set_agent_pref_velocity(index, tuple(goal))
    solver.do_step()
    found = [solver.get_agent_velocity(int(index)) for index in own]
    return np.array([(velocity.x, velocity.y) for velocity in found])
