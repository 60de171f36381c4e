"""A sensor without physics: beams that measure known lengths, and an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from seoro.bridges.wire import Quantity, SensorFault
from sim_nodes.faults.checks import Observation, SensorCheck
from sim_nodes.faults.devices import sensor_check
from sim_nodes.geometry import Array
from sim_nodes.noise import Noise
from sim_nodes.sensors.sensor_pipeline import Sensor, SensorPipeline, Values

BEAMS = 90


@dataclass(frozen=True)
class Reading:
    ranges: Array
    angle: Array


class Ruler(Sensor[Reading]):
    """Measures lengths from 1 to 3 m, of which every tenth is out of range, with noise."""

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


def pipeline(*faults: SensorFault, seed: int = 0) -> SensorPipeline[Reading]:
    """Return the pipeline of a ruler's samples, with faults."""
    made: SensorPipeline[Reading] = SensorPipeline(Ruler(), lambda purpose: Noise(seed, purpose))
    made.in_use = True
    for fault in faults:
        made.add_fault(fault)
    return made


def measured(
    fault: SensorFault, *, declared: tuple[SensorFault, ...], way: SensorPipeline[Any], ticks: int
) -> tuple[int, SensorCheck]:
    """Check a fault until it is confirmed, or for a number of ticks, in a pipeline with other faults."""
    check = sensor_check(fault, way.sensor)
    kinds: dict[str, SensorFault] = {each.kind: each for each in declared}
    for tick in range(ticks):
        way.update(tick)
        check.observe(Observation(tick, way.truth, way.arrived, kinds))
        if check.is_confirmed:
            return tick, check
    return ticks, check
