"""Contacts by which a door or a lift presses against something.

The normals of contacts do not decide this: at the edge of a thin leaf, engines may find a normal across the leaf.
So an entity is an obstacle if it touches a body at the side in the direction of motion.
"""

from __future__ import annotations

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.buildings.parts import Place
from sim_nodes.geometry import Array, rotation_matrix, wrap
from sim_nodes.physics import BodyModel, BodyState, Box, ContactPoint
from sim_nodes.ticks import TICK

PRESSING = 1e-3  # [m/s] of the touched point
EDGE = 0.02  # [m] maximum distance of a contact from the side in the direction of motion
LEVEL = 0.7  # vertical component of a normal from which an entity lies on a body


@dataclass(frozen=True)
class BodyMotion:
    """The motion of a body until the next tick.

    Attributes:
        state: Its present state.
        linear: Velocity of its origin, shape (3,) [m/s].
        rate: Yaw rate [rad/s].
    """

    state: BodyState
    linear: Array
    rate: float

    @classmethod
    def between(cls, state: BodyState, place: Place) -> BodyMotion:
        """Return the motion from a state to a pose."""
        rate = float(wrap(place.yaw - state.planar.yaw)) / TICK
        return cls(state, np.subtract(place[:3], state.position) / TICK, rate)

    def presses(self, point: ContactPoint, model: BodyModel) -> bool:
        """Whether the body, a box, presses against the entity at a contact point; loads on it do not count."""
        if point.normal[2] > LEVEL:
            return False
        [part] = model.parts
        assert isinstance(part.shape, Box)
        arm = np.subtract(point.position, self.state.position)
        velocity = self.linear + self.rate * np.array([-arm[1], arm[0], 0.0])
        turn = rotation_matrix(self.state.orientation).T
        local, along = turn @ arm - part.position, turn @ velocity
        axis = int(np.abs(along).argmax())
        half = part.shape.size[axis] / 2.0
        ahead = float(np.sign(along[axis])) * float(local[axis])
        return bool(abs(along[axis]) > PRESSING and ahead > half - min(EDGE, half))
