"""Watches on the samples of sensors: bumpers, ranges, forces, cameras and rates."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from seoro.bridges.wire import DeadSector, Outcome, Quantity
from seoro.deferred import dataclass
from sim_nodes.sensors.base import Bumps
from sim_nodes.sensors.imaging import Segments
from sim_nodes.sensors.load import Wrench
from sim_nodes.sensors.sensor_pipeline import dead_beams
from sim_nodes.ticks import TICK
from sim_nodes.watches import Watch, Watched

T = TypeVar("T")

ROUNDING = 1e-9


@dataclass(frozen=True)
class SensorWatch(Watch):
    """A watch on a sensor of a robot."""

    robot: str
    sensor: str

    def rebased(self, before: Watched, now: Watched) -> SensorWatch:
        """Return the same watch; marks the sensor as in use."""
        now.pipeline(self.robot, self.sensor).activate()
        return self

    def latest(self, world: Watched, kind: type[T]) -> T | None:
        """Return the data of the latest sample, which has the kind of the sensor; None without a sample."""
        sample = world.pipeline(self.robot, self.sensor).latest
        if sample is None:
            return None
        assert isinstance(sample.data, kind)
        return sample.data


@dataclass(frozen=True)
class SampleWatch(SensorWatch):
    """True after a sample of a sensor has arrived since a tick."""

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

    zone: str
    entity: str

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        found = self.latest(world, Bumps)
        bumps = () if found is None else found.bumps
        return any(self.zone in ("", bump.zone) and self.entity in ("", bump.entity) for bump in bumps)


@dataclass(frozen=True)
class RangeWatch(SensorWatch):
    """True when a ranging sensor has a range below a distance [m] between two bearings [rad]."""

    distance: float
    start: float
    end: float

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        pipeline = world.pipeline(self.robot, self.sensor)
        if pipeline.latest is None:
            return False
        ranges = pipeline.sensor.values(pipeline.latest.data)[Quantity.LENGTH]
        beams = dead_beams(DeadSector(start=self.start, end=self.end), pipeline.sensor.bearings)
        return bool(np.min(ranges[beams], initial=np.inf) < self.distance)


@dataclass(frozen=True)
class ForceWatch(SensorWatch):
    """True when a force-torque sensor measures more than a force [N]."""

    force: float

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        wrench = self.latest(world, Wrench)
        return wrench is not None and bool(np.linalg.norm(wrench.force) > self.force)


@dataclass(frozen=True)
class SightWatch(SensorWatch):
    """True when a segmentation sensor sees an entity, on at least a share of its picture."""

    entity: str
    share: float

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        segments = self.latest(world, Segments)
        seen = 0.0 if segments is None else segments.share(self.entity)
        return seen > 0.0 and seen >= self.share


@dataclass(frozen=True)
class RateWatch(SensorWatch):
    """True at the end of a period; the result is whether the rate of samples [1/s] was in bounds."""

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
