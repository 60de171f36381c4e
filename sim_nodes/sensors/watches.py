"""Watches on what arrives from sensors; see `sim_nodes.watches`."""

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

    def carried_over(self, before: Watched, now: Watched) -> SensorWatch:
        """The same; the sensor is in use by it."""
        now.feed(self.robot, self.sensor).in_use = True
        return self


@dataclass(frozen=True)
class SampleWatch(SensorWatch):
    """True when a sample of a sensor has arrived after a tick."""

    robot: str
    sensor: str
    since: int

    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""
        arrival = world.feed(self.robot, self.sensor).arrival
        return arrival is not None and arrival > self.since

    def carried_over(self, before: Watched, now: Watched) -> SampleWatch:
        """For a sample after the present tick."""
        super().carried_over(before, now)
        return replace(self, since=now.tick)


@dataclass(frozen=True)
class BumperWatch(SensorWatch):
    """True when a zone of a bumper is pressed by an entity; empty names are any."""

    robot: str
    sensor: str
    zone: str
    entity: str

    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""
        latest = world.feed(self.robot, self.sensor).latest
        if latest is None:
            return False
        assert isinstance(latest.data, Bumps)
        return any(self.zone in ("", bump.zone) and self.entity in ("", bump.entity) for bump in latest.data.bumps)


@dataclass(frozen=True)
class RangeWatch(SensorWatch):
    """True when a lidar sees something nearer than a distance [m] from one bearing to another [rad]."""

    robot: str
    sensor: str
    distance: float
    start: float
    end: float

    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""
        feed = world.feed(self.robot, self.sensor)
        if feed.latest is None:
            return False
        assert isinstance(feed.latest.data, Scan)
        beams = dead_beams(DeadSector(start=self.start, end=self.end), feed.sensor.bearings)
        return bool(np.min(feed.latest.data.ranges[beams], initial=np.inf) < self.distance)


@dataclass(frozen=True)
class RateWatch(SensorWatch):
    """True when a time is over; then the rate of the samples that have arrived in it is in bounds [1/s] or not."""

    robot: str
    sensor: str
    count: int  # at its beginning
    begin: int  # [ticks]
    end: int
    lowest: float
    highest: float

    def holds(self, world: Watched) -> bool:
        """Whether it is over."""
        return world.tick >= self.end

    def carried_over(self, before: Watched, now: Watched) -> RateWatch:
        """Counted anew, for as long."""
        super().carried_over(before, now)
        count = now.feed(self.robot, self.sensor).count
        return replace(self, count=count, begin=now.tick, end=now.tick + self.end - self.begin)

    def result(self, world: Watched) -> tuple[Outcome, str]:
        """Whether the rate was in bounds, and which it was."""
        count = world.feed(self.robot, self.sensor).count - self.count
        duration = (self.end - self.begin) * TICK
        rate = count / duration
        fits = self.lowest - ROUNDING <= rate <= self.highest + ROUNDING
        message = (
            f"{count} samples of {self.robot}/{self.sensor} have arrived in {duration:g} s, {rate:.4g} a second; "
            f"{self.lowest:g} to {self.highest:g} were expected"
        )
        return (Outcome.SUCCEEDED if fits else Outcome.ABORTED), message
