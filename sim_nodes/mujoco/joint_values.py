"""The values of all joints in a state of MuJoCo, as lists: single items of arrays take ten times as long."""

from __future__ import annotations

from functools import cached_property
from typing import Any


class JointValues:
    """Values of one state, each converted when it is first used.

    Args:
        data: The data with the present state; it must not change afterwards.
    """

    def __init__(self, data: Any) -> None:
        self._data = data

    @cached_property
    def positions(self) -> list[float]:
        """Generalized positions (`qpos`) [m, rad, quaternions]."""
        values: list[float] = self._data.qpos.tolist()
        return values

    @cached_property
    def speeds(self) -> list[float]:
        """Generalized velocities (`qvel`) [m/s, rad/s]."""
        values: list[float] = self._data.qvel.tolist()
        return values
