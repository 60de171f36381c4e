"""Mechanical power of the motors of a robot in MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


class MotorPower:
    """Power by the forces of actuators on degrees of freedom, and their speeds.

    Args:
        model: The model.
        base: Number of the base's body.
        joints: Degrees of freedom of joints with motors.
        drives_base: Whether motors also act on the base itself, as those of planar drives.
    """

    def __init__(self, model: Any, base: int, joints: Sequence[int], drives_base: bool) -> None:
        self._joints = np.array(joints, dtype=np.intp)
        first = int(model.jnt_dofadr[model.body_jntadr[base]]) if drives_base else 0
        self._base = slice(first, first + 6) if drives_base else None

    def delivered(self, data: Any) -> float:
        """See `MeasuresPower.motor_power`."""
        forces, speeds = data.qfrc_actuator, data.qvel
        power = float(np.maximum(forces[self._joints] * speeds[self._joints], 0.0).sum())
        if self._base is not None:
            power += max(0.0, float(forces[self._base] @ speeds[self._base]))
        return power
