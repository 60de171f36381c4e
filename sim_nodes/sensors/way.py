"""The way of what a device gives to those who use it, with the faults that lie on it and what is under way."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from seoro.bridges.wire import CameraFault, Delay, MessageLoss, SensorFault
from sim_nodes.noise import Noise
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

F = TypeVar("F", bound=SensorFault | CameraFault)
D = TypeVar("D")
U = TypeVar("U")

ROUNDING = 1e-9


class Way(Stateful, Generic[F, D, U]):
    """A way on which faults of type F lie, which gives data of type D and holds what is under way as U.

    Args:
        noise: Gives the source of the random numbers of a purpose.

    Attributes:
        faults: The faults that lie on the way, by their kinds.
    """

    STATE: ClassVar[tuple[str, ...]] = ("faults", "_has_supply", "_frozen", "_under_way")

    def __init__(self, noise: Callable[[str], Noise]) -> None:
        self.faults: dict[str, F] = {}
        self._has_supply = True
        self._frozen: D | None = None  # what is given again and again
        self._under_way: deque[tuple[int, U]] = deque()  # with ticks, the first one first
        self._noise_of_messages = noise("message_loss")

    def put(self, fault: F) -> None:
        """Lay a fault on the way, in the place of another of its kind."""
        self.faults[fault.kind] = fault
        self._start_over(fault.kind)

    def lift(self, kind: str) -> None:
        """Take a fault off the way."""
        self.faults.pop(kind, None)
        self._start_over(kind)

    def supply(self, on: bool) -> None:
        """Cut off the supply of power, or bring it back."""
        self._has_supply = on
        self._start_over("power_loss")

    def _start_over(self, kind: str) -> None:
        if kind == "freeze":
            self._frozen = None
        if kind in ("delay", "power_loss"):
            self._under_way.clear()  # what is under way then is lost

    @property
    def _has_power(self) -> bool:
        return self._has_supply and "power_loss" not in self.faults

    @property
    def _lateness(self) -> int:
        """How long everything is under way at least [ticks]."""
        delay = self.faults.get("delay")
        return math.ceil(delay.time / TICK - ROUNDING) if isinstance(delay, Delay) else 0

    def _is_lost(self, tick: int) -> bool:
        """Whether what is sent in a tick gets lost."""
        loss = self.faults.get("message_loss")
        return isinstance(loss, MessageLoss) and self._noise_of_messages.at(tick).random() < loss.probability
