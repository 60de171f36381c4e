"""The way of a sensor's samples to those who use them, on which faults lie."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadBeams,
    DeadSector,
    GaussianNoise,
    Quantity,
    SensorFault,
)
from sim_nodes.noise import Noise
from sim_nodes.sensors.beams import blind_beams
from sim_nodes.sensors.sensor import Sample, Sensor
from sim_nodes.sensors.way import Way

T = TypeVar("T")

OF_VALUES = (BeamLoss, DeadSector, DeadBeams, Bias, GaussianNoise)


class Feed(Way[SensorFault, T, Sample[T]], Generic[T]):
    """The way of a sensor's samples to those who use them.

    Args:
        sensor: The sensor.
        noise: Gives the source of the random numbers of a purpose.
        always: Whether it senses also when nobody uses it.

    A sensor that nobody uses does not sense. That changes nothing for others: each draws its own random numbers.

    Attributes:
        in_use: Whether somebody counts on its samples.
        truth: What a sound sensor would have sent in the last tick; None if none was due.
        arrived: The sample that has arrived in the last tick.
        latest: The sample that has arrived last.
        count: How many samples have arrived.
        arrival: The tick in which the last one has.
    """

    STATE = (*Way.STATE, "sensor", "in_use", "truth", "arrived", "latest", "count", "arrival")

    def __init__(self, sensor: Sensor[T], noise: Callable[[str], Noise], *, always: bool = False) -> None:
        super().__init__(noise)
        self.sensor = sensor
        self._always = always
        self.in_use = False
        self.truth: Sample[T] | None = None
        self.arrived: Sample[T] | None = None
        self.latest: Sample[T] | None = None
        self.count = 0
        self.arrival: int | None = None
        self._noise = {quantity: noise(f"gaussian_noise/{quantity}") for quantity in sensor.quantities}
        self._noise_of_beams = noise("beam_loss")

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
        if not self._has_power or self._is_lost(truth.tick):
            return
        data = self._distorted(truth)
        if "freeze" in self.faults:
            self._frozen = data = data if self._frozen is None else self._frozen
        self._under_way.append((truth.tick + self._lateness, Sample(truth.tick, data)))  # by when it arrives

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
