"""A sensor without physics: beams that measure known lengths, and an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from seoro.bridges.wire import Quantity, SensorFault
from sim_nodes.faults.check import Observation, SensorCheck
from sim_nodes.faults.devices import sensor_check
from sim_nodes.geometry import Array
from sim_nodes.noise import Noise
from sim_nodes.sensors.feed import Feed
from sim_nodes.sensors.sensor import Values

BEAMS = 90


@dataclass(frozen=True)
class Reading:
    ranges: Array
    angle: Array


class Ruler:
    """Measures lengths from 1 to 3 m, of which every tenth is out of sight, with noise of its own."""

    period = 2
    quantities = (Quantity.LENGTH, Quantity.ANGLE)
    bearings = np.linspace(-np.pi, np.pi, BEAMS, endpoint=False)
    limits = (0.2, 4.0)

    def read(self, tick: int) -> Reading:
        random = Noise(0, "ruler").at(tick)
        ranges = np.linspace(1.0, 3.0, BEAMS) + random.normal(0.0, 0.01, BEAMS)
        ranges[::10] = np.inf
        return Reading(ranges, random.normal(3.1, 0.01, 1))

    def values(self, data: Reading) -> Values:
        return {Quantity.LENGTH: data.ranges, Quantity.ANGLE: data.angle}

    def with_values(self, data: Reading, values: Values) -> Reading:
        ranges = values[Quantity.LENGTH]
        ranges = np.where((ranges < self.limits[0]) | (ranges > self.limits[1]), np.inf, ranges)
        return Reading(ranges, (values[Quantity.ANGLE] + np.pi) % (2 * np.pi) - np.pi)


def feed(*faults: SensorFault, seed: int = 0) -> Feed[Reading]:
    """The way of a ruler's samples, with faults on it."""
    made: Feed[Reading] = Feed(Ruler(), lambda purpose: Noise(seed, purpose))
    made.in_use = True
    for fault in faults:
        made.put(fault)
    return made


def measured(
    fault: SensorFault, *, declared: tuple[SensorFault, ...], way: Feed[Any], ticks: int
) -> tuple[int, SensorCheck]:
    """Measure a fault until it is found, or for a number of ticks, on a way on which there may be others."""
    check = sensor_check(fault, way.sensor)
    kinds: dict[str, SensorFault] = {each.kind: each for each in declared}
    for tick in range(ticks):
        way.pass_tick(tick)
        check.observe(Observation(tick, way.truth, way.arrived, kinds))
        if check.holds:
            return tick, check
    return ticks, check
