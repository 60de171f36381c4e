"""Bodies of a MuJoCo model that move by given velocities; see `DrivesBodies`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim_nodes.driven import upright_velocities, yaws
from sim_nodes.geometry import Array
from sim_nodes.physics import BodyModel, BodyState


class DrivenBodies:
    """The driven bodies of a compiled model.

    Args:
        model: The model.
        bases: Numbers of all bodies by name.
        added: Added bodies, with the states in which they were added.
    """

    def __init__(
        self, model: Any, bases: Mapping[str, int], added: Mapping[str, tuple[BodyModel, BodyState]]
    ) -> None:
        names = [name for name, (body, _) in added.items() if body.driven]
        joints = model.body_jntadr[[bases[name] for name in names]] if names else np.zeros(0, dtype=np.int64)
        self._poses = model.jnt_qposadr[joints][:, None] + np.arange(7)
        self._speeds = model.jnt_dofadr[joints][:, None] + np.arange(6)
        self._falling = np.array([0.0 if added[name][0].built_in else 1.0 for name in names])

    def poses(self, data: Any) -> Array:
        """Return x, y [m] and yaw [rad] of each body, shape (n, 3)."""
        frames = data.qpos[self._poses]
        return np.column_stack([frames[:, :2], yaws(frames[:, 3:])])

    def drive(self, data: Any, velocities: Array, heights: Array) -> None:
        """Set velocities: x, y [m/s] and yaw rate [rad/s], shape (n, 3), and heights to reach [m], shape (n,)."""
        frames = data.qpos[self._poses]
        climbs = heights - frames[:, 2]
        linear, angular = upright_velocities(velocities, climbs, frames[:, 3:], self._falling)
        # Angular velocities of free joints are in the frame of the body, which leans very little.
        cos, sin = np.cos(turns := yaws(frames[:, 3:])), np.sin(turns)
        about_x, about_y = angular[:, 0].copy(), angular[:, 1].copy()
        angular[:, 0], angular[:, 1] = cos * about_x + sin * about_y, cos * about_y - sin * about_x
        data.qvel[self._speeds] = np.hstack([linear, angular])
