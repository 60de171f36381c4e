"""The way of a sensor's samples to those who use them, on which faults lie."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadBeams,
    DeadSector,
    Delay,
    GaussianNoise,
    MessageLoss,
    Quantity,
    SensorFault,
)
from sim_nodes.noise import Noise
from sim_nodes.sensors.beams import blind_beams
from sim_nodes.sensors.sensor import Sample, Sensor
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

T = TypeVar("T")

OF_VALUES = (BeamLoss, DeadSector, DeadBeams, Bias, GaussianNoise)
ROUNDING = 1e-9


class Feed(Stateful, Generic[T]):
    """The way of a sensor's samples to those who use them.

    Args:
        sensor: The sensor.
        noise: Gives the source of the random numbers of a purpose.
        always: Whether it senses also when nobody uses it.

    A sensor that nobody uses does not sense. That changes nothing for others: each draws its own random numbers.

    Attributes:
        in_use: Whether somebody counts on its samples.
        faults: The faults that lie on the way, by their kinds.
        truth: What a sound sensor would have sent in the last tick; None if none was due.
        arrived: The sample that has arrived in the last tick.
        latest: The sample that has arrived last.
        count: How many samples have arrived.
        arrival: The tick in which the last one has.
    """

    STATE = (
        "sensor",
        "in_use",
        "_has_supply",
        "faults",
        "truth",
        "arrived",
        "latest",
        "count",
        "arrival",
        "_frozen",
        "_under_way",
    )

    def __init__(self, sensor: Sensor[T], noise: Callable[[str], Noise], *, always: bool = False) -> None:
        self.sensor = sensor
        self._always = always
        self.in_use = False
        self.faults: dict[str, SensorFault] = {}
        self.truth: Sample[T] | None = None
        self.arrived: Sample[T] | None = None
        self.latest: Sample[T] | None = None
        self.count = 0
        self.arrival: int | None = None
        self._noise = {quantity: noise(f"gaussian_noise/{quantity}") for quantity in sensor.quantities}
        self._noise_of_beams = noise("beam_loss")
        self._noise_of_messages = noise("message_loss")
        self._has_supply = True
        self._frozen: T | None = None
        self._under_way: deque[tuple[int, Sample[T]]] = deque()  # with the ticks in which they arrive

    def put(self, fault: SensorFault) -> None:
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

    def pass_tick(self, tick: int) -> None:
        """Let the sensor sense if it is due, and samples arrive."""
        self.truth = self.arrived = None
        if (self.in_use or self._always) and tick % self.sensor.period == 0:
            self.truth = Sample(tick, self.sensor.read(tick))
            self._send(self.truth)
        if self._under_way and self._under_way[0][0] <= tick:
            self.latest = self.arrived = self._under_way.popleft()[1]
            self.count, self.arrival = self.count + 1, tick

    def _send(self, truth: Sample[T]) -> None:
        """Send a sample, as the faults leave it."""
        if "power_loss" in self.faults or not self._has_supply:
            return
        loss = self.faults.get("message_loss")
        if isinstance(loss, MessageLoss) and self._noise_of_messages.at(truth.tick).random() < loss.probability:
            return
        data = self._distorted(truth)
        if "freeze" in self.faults:
            self._frozen = data = data if self._frozen is None else self._frozen
        self._under_way.append((truth.tick + self._lateness(), Sample(truth.tick, data)))

    def _lateness(self) -> int:
        """How long a sample is under way [ticks]."""
        delay = self.faults.get("delay")
        return math.ceil(delay.time / TICK - ROUNDING) if isinstance(delay, Delay) else 0

    def _distorted(self, truth: Sample[T]) -> T:
        """The data of a sample with the faults of its values."""
        faults = [fault for fault in self.faults.values() if isinstance(fault, OF_VALUES)]
        if not faults:
            return truth.data
        values = {quantity: array.copy() for quantity, array in self.sensor.values(truth.data).items()}
        for fault in faults:
            match fault:
                case BeamLoss() | DeadSector() | DeadBeams():
                    random = self._noise_of_beams.at(truth.tick)
                    values[Quantity.LENGTH][blind_beams(fault, self.sensor.bearings, random)] = np.inf
                case Bias(offset=offset):
                    for quantity, off in offset.items():
                        values[quantity] += off
                case GaussianNoise(deviation=deviation):
                    for quantity, std in deviation.items():
                        errors = self._noise[quantity].at(truth.tick)
                        values[quantity] += errors.normal(0.0, std, len(values[quantity]))
        return self.sensor.with_values(truth.data, values)
