"""Planar drives in PyBullet: before each step, forces on the base pull it to the velocity of its wheels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import rotation_matrix
from sim_nodes.physics import BodyState
from sim_nodes.pybullet.drives import PybulletDrive
from sim_nodes.pybullet.model import BASE
from sim_nodes.robots.kinematics import AT_REST, base_motion
from sim_nodes.robots.traction import COASTING, RESPONSE, Traction


@dataclass(frozen=True)
class BaseWork:
    """Work of the motors on a base up to the step before the last.

    Attributes:
        total: Work [J].
        forces: Forces ahead, to the left, and torque of the last step [N], [N m].
        speeds: Velocities in its beginning [m/s], [rad/s].
    """

    total: float = 0.0
    forces: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speeds: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def followed(
        self, forces: tuple[float, float, float], speeds: tuple[float, float, float], timestep: float
    ) -> BaseWork:
        """Return the work when the next step begins; motors that brake count as 0."""
        power = sum([f * (v + w) for f, v, w in zip(self.forces, self.speeds, speeds, strict=True)]) / 2.0
        return BaseWork(self.total + max(0.0, power) * timestep, forces, speeds)


class PlanarForces:
    """The forces on the base of a robot.

    Args:
        bullet: The Bullet client.
        drive: Wheels of the robot.
        traction: Motor of its base.
        state: Reads the state of its base.
        timestep: Length of a step [s].

    Attributes:
        done: Work of the motors on the base.
    """

    def __init__(
        self,
        bullet: Any,
        drive: PybulletDrive,
        traction: Traction,
        state: Callable[[], BodyState],
        timestep: float,
    ) -> None:
        self._bullet, self._drive, self._traction, self._state = bullet, drive, traction, state
        self._timestep = timestep
        self.done = BaseWork()

    def apply(self) -> None:
        """Apply the forces of one step; Bullet removes them after it."""
        traction, command, state = self._traction, self._drive.command, self._state()
        on = command.has_power
        wanted = base_motion(self._drive.drive, command.targets) if on else AT_REST
        turn = rotation_matrix(state.orientation)
        ahead, left, _ = (turn.T @ state.linear).tolist()
        rate = float(turn[:, 2] @ state.angular)
        response = RESPONSE if on else COASTING
        sideways = RESPONSE if traction.holds_side else response
        force = _within(traction.mass * (wanted.linear - ahead) / response, traction.force)
        side = _within(traction.mass * (wanted.lateral - left) / sideways, traction.side_force)
        torque = _within(traction.inertia * (wanted.angular - rate) / response, traction.torque)
        forces = (force, side, torque) if on else (0.0, 0.0, 0.0)
        self.done = self.done.followed(forces, (ahead, left, rate), self._timestep)
        # Bullet's torques on a base are not in the frame that they are documented for; a pair of forces is.
        half = torque / (2.0 * traction.lever)
        for pushes, place in (
            ((force, side, 0.0), (0.0, 0.0, 0.0)),
            ((-half, 0.0, 0.0), (0.0, traction.lever, 0.0)),
            ((half, 0.0, 0.0), (0.0, -traction.lever, 0.0)),
        ):
            point = np.add(state.position, turn @ place)
            self._bullet.applyExternalForce(
                self._drive.body, BASE, (turn @ pushes).tolist(), point.tolist(), self._bullet.WORLD_FRAME
            )


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
