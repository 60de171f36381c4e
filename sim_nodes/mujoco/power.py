"""Mechanical power of the motors of a robot in MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sim_nodes.mujoco.joint_values import JointValues


class MotorPower:
    """Power by the forces of actuators on degrees of freedom, and their speeds.

    Args:
        model: The model.
        base: Number of the base's body.
        joints: Degrees of freedom of joints with motors.
        drives_base: Whether motors also act on the base itself, as those of planar drives.
    """

    def __init__(self, model: Any, base: int, joints: Sequence[int], drives_base: bool) -> None:
        self._joints = tuple(joints)
        first = int(model.jnt_dofadr[model.body_jntadr[base]]) if drives_base else 0
        self._base = range(first, first + 6) if drives_base else range(0)

    def delivered(self, values: JointValues) -> float:
        """See `MeasuresPower.motor_power`."""
        powers = values.powers
        power = sum([max(powers[joint], 0.0) for joint in self._joints])
        return power + max(0.0, sum([powers[joint] for joint in self._base])) if self._base else power
