"""Laser scans in the tracks of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from seoro.bridges import wire
from sim_nodes.robots.robot import Robot
from sim_nodes.sensors.lidar import Lidar

TOLERANCE = 1e-9  # [s]
SCALE = 1_000  # ranges are rounded to 1 / SCALE


class ScanSamples:
    """Scans that were sampled last.

    Args:
        rate: Scans of each lidar per second, at most; 0 for none.
    """

    def __init__(self, rate: float = 0.0) -> None:
        self._period = 1.0 / rate if rate else 0.0
        self._due = 0.0  # time of the next scans [s]
        self._ticks: dict[tuple[str, str], int] = {}  # of the sampled scans

    def sample(self, time: float, tick: int, robots: Mapping[str, Robot]) -> Iterator[wire.TrackScan]:
        """Yield the new scans, with the injected faults.

        Args:
            time: Present time [s].
            tick: Present tick.
            robots: Robots by name.
        """
        if not self._period or time < self._due - TOLERANCE:
            return
        self._due = time + self._period
        for name, robot in robots.items():
            for sensor, pipeline in robot.sensors.items():
                lidar = pipeline.sensor
                if not isinstance(lidar, Lidar):
                    continue
                found = pipeline.peek(tick)
                if found is None or self._ticks.get((name, sensor)) == found.tick:
                    continue
                self._ticks[name, sensor] = found.tick
                ranges = np.round(found.data.ranges * SCALE) / SCALE
                yield wire.TrackScan(
                    robot=name,
                    sensor=sensor,
                    mount=(lidar.declaration.x, lidar.declaration.y, 0.0),
                    first=float(lidar.bearings[0]),
                    step=math.tau / lidar.declaration.beams,
                    ranges=ranges.astype("<f4").tobytes(),
                )

    def copy(self) -> ScanSamples:
        """Return a copy."""
        other = ScanSamples()
        other._period, other._due, other._ticks = self._period, self._due, dict(self._ticks)
        return other
