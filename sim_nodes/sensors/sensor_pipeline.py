"""The pipeline of a sensor's samples, with faults."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from seoro.bridges import wire
from sim_nodes.noise import Noise
from sim_nodes.sensors.beams import blind_beams
from sim_nodes.sensors.delay_line import DelayLine
from sim_nodes.sensors.sensor import Sample, Sensor

T = TypeVar("T")

VALUE_FAULTS = (wire.BeamLoss, wire.DeadSector, wire.DeadBeams, wire.Bias, wire.GaussianNoise)


class SensorPipeline(DelayLine[wire.SensorFault, T, Sample[T]], Generic[T]):
    """The pipeline of a sensor's samples to clients.

    Args:
        sensor: The sensor.
        noise: Factory of noise sources by purpose.
        always: Whether the sensor is active without clients.

    Without clients, a sensor is inactive. This does not affect others: each draws its own random numbers.

    Attributes:
        in_use: Whether a client uses its samples.
        truth: Sample of a sound sensor in the last tick; None if none was due.
        arrived: Sample that arrived in the last tick.
        latest: Last sample that arrived.
        count: Number of samples that arrived.
        arrival: Tick in which the last one arrived.
    """

    STATE = (*DelayLine.STATE, "sensor", "in_use", "truth", "arrived", "latest", "count", "arrival")

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

    def update(self, tick: int) -> None:
        """Sample the sensor if it is due, and deliver samples."""
        self.truth = self.arrived = None
        if (self.in_use or self._always) and tick % self.sensor.period == 0:
            self.truth = Sample(tick, self.sensor.read(tick))
            self._send(self.truth)
        if self._in_transit and self._in_transit[0][0] <= tick:
            self.latest = self.arrived = self._in_transit.popleft()[1]
            self.count, self.arrival = self.count + 1, tick

    def _send(self, truth: Sample[T]) -> None:
        """Send a sample through the faults."""
        if not self._has_power or self._is_lost(truth.tick):
            return
        data = self._distorted(truth)
        if "freeze" in self.faults:
            self._frozen = data = data if self._frozen is None else self._frozen
        self._in_transit.append((truth.tick + self._delay_ticks, Sample(truth.tick, data)))  # by arrival

    def _distorted(self, truth: Sample[T]) -> T:
        """Return the data of a sample with value faults."""
        faults = [fault for fault in self.faults.values() if isinstance(fault, VALUE_FAULTS)]
        if not faults:
            return truth.data
        values = {quantity: array.copy() for quantity, array in self.sensor.values(truth.data).items()}
        for fault in faults:
            match fault:
                case wire.BeamLoss() | wire.DeadSector() | wire.DeadBeams():
                    random = self._noise_of_beams.at(truth.tick)
                    values[wire.Quantity.LENGTH][blind_beams(fault, self.sensor.bearings, random)] = np.inf
                case wire.Bias(offset=offset):
                    for quantity, off in offset.items():
                        values[quantity] += off
                case wire.GaussianNoise(deviation=deviation):
                    for quantity, std in deviation.items():
                        errors = self._noise[quantity].at(truth.tick)
                        values[quantity] += errors.normal(0.0, std, len(values[quantity]))
        return self.sensor.with_values(truth.data, values)
