"""Watches on delivered sensor samples; see `sim_nodes.watches`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from seoro.bridges.wire import DeadSector, Outcome
from sim_nodes.sensors.beams import dead_beams
from sim_nodes.sensors.bumper import Bumps
from sim_nodes.sensors.lidar import Scan
from sim_nodes.ticks import TICK
from sim_nodes.watches import Watch, Watched

ROUNDING = 1e-9


class SensorWatch(Watch):
    """A watch on a sensor of a robot."""

    robot: str
    sensor: str

    def rebased(self, before: Watched, now: Watched) -> SensorWatch:
        """Return the same watch; marks the sensor as in use."""
        now.pipeline(self.robot, self.sensor).in_use = True
        return self


@dataclass(frozen=True)
class SampleWatch(SensorWatch):
    """True after a sample of a sensor has arrived since a tick."""

    robot: str
    sensor: str
    since: int

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        arrival = world.pipeline(self.robot, self.sensor).arrival
        return arrival is not None and arrival > self.since

    def rebased(self, before: Watched, now: Watched) -> SampleWatch:
        """Return a watch for samples after the present tick."""
        super().rebased(before, now)
        return replace(self, since=now.tick)


@dataclass(frozen=True)
class BumperWatch(SensorWatch):
    """True when a zone of a bumper is pressed by an entity; empty names match all."""

    robot: str
    sensor: str
    zone: str
    entity: str

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        latest = world.pipeline(self.robot, self.sensor).latest
        if latest is None:
            return False
        assert isinstance(latest.data, Bumps)
        return any(self.zone in ("", bump.zone) and self.entity in ("", bump.entity) for bump in latest.data.bumps)


@dataclass(frozen=True)
class RangeWatch(SensorWatch):
    """True when a lidar has a range below a distance [m] between two bearings [rad]."""

    robot: str
    sensor: str
    distance: float
    start: float
    end: float

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        pipeline = world.pipeline(self.robot, self.sensor)
        if pipeline.latest is None:
            return False
        assert isinstance(pipeline.latest.data, Scan)
        beams = dead_beams(DeadSector(start=self.start, end=self.end), pipeline.sensor.bearings)
        return bool(np.min(pipeline.latest.data.ranges[beams], initial=np.inf) < self.distance)


@dataclass(frozen=True)
class RateWatch(SensorWatch):
    """True at the end of a period; the result is whether the rate of samples [1/s] was in bounds."""

    robot: str
    sensor: str
    count: int  # at the start
    begin: int  # [ticks]
    end: int
    lowest: float
    highest: float

    def holds(self, world: Watched) -> bool:
        """Whether the period is over."""
        return world.tick >= self.end

    def rebased(self, before: Watched, now: Watched) -> RateWatch:
        """Return a watch that counts anew, for the same duration."""
        super().rebased(before, now)
        count = now.pipeline(self.robot, self.sensor).count
        return replace(self, count=count, begin=now.tick, end=now.tick + self.end - self.begin)

    def result(self, world: Watched) -> tuple[Outcome, str]:
        """Return whether the rate was in bounds, and a text with the rate."""
        count = world.pipeline(self.robot, self.sensor).count - self.count
        duration = (self.end - self.begin) * TICK
        rate = count / duration
        fits = self.lowest - ROUNDING <= rate <= self.highest + ROUNDING
        message = (
            f"{count} samples of {self.robot}/{self.sensor} have arrived in {duration:g} s, {rate:.4g} a second; "
            f"expected {self.lowest:g} to {self.highest:g}"
        )
        return (Outcome.SUCCEEDED if fits else Outcome.ABORTED), message
