"""Delay line from a device to its clients, with faults and data in transit."""

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


class DelayLine(Stateful, Generic[F, D, U]):
    """A delay line with faults of type F, which delivers data of type D, and has items of type U in transit.

    Args:
        noise: Factory of noise sources by purpose.

    Attributes:
        faults: Faults by kind.
    """

    STATE: ClassVar[tuple[str, ...]] = ("faults", "_has_supply", "_frozen", "_in_transit")

    def __init__(self, noise: Callable[[str], Noise]) -> None:
        self.faults: dict[str, F] = {}
        self._has_supply = True
        self._frozen: D | None = None  # repeated by a freeze
        self._in_transit: deque[tuple[int, U]] = deque()  # with ticks, oldest first
        self._noise_of_messages = noise("message_loss")

    def add_fault(self, fault: F) -> None:
        """Add a fault; it replaces another of its kind."""
        self.faults[fault.kind] = fault
        self._start_over(fault.kind)

    def remove_fault(self, kind: str) -> None:
        """Remove the fault of a kind."""
        self.faults.pop(kind, None)
        self._start_over(kind)

    def set_power(self, on: bool) -> None:
        """Switch the power supply."""
        self._has_supply = on
        self._start_over("power_loss")

    def _start_over(self, kind: str) -> None:
        if kind == "freeze":
            self._frozen = None
        if kind in ("delay", "power_loss"):
            self._in_transit.clear()  # items in transit are lost

    @property
    def _has_power(self) -> bool:
        return self._has_supply and "power_loss" not in self.faults

    @property
    def _delay_ticks(self) -> int:
        """Minimum delay of all items [ticks]."""
        delay = self.faults.get("delay")
        return math.ceil(delay.time / TICK - ROUNDING) if isinstance(delay, Delay) else 0

    def _is_lost(self, tick: int) -> bool:
        """Whether an item sent in a tick is lost."""
        loss = self.faults.get("message_loss")
        return isinstance(loss, MessageLoss) and self._noise_of_messages.at(tick).random() < loss.probability
