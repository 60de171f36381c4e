"""Watches of measures of robots and other entities."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import assert_never

from seoro.bridges.wire import Outcome
from seoro.deferred import dataclass
from seoro.robotics.measures import ONLY_ROBOTS, UNITS, Area, Measure, MeasureLimit
from sim_nodes.geometry import Quaternion
from sim_nodes.physics import BodyState
from sim_nodes.ticks import TICK
from sim_nodes.watches import Watch, Watched

SUMS = (Measure.PATH_LENGTH, Measure.TIME_IN_AREA, Measure.WORK)  # since the watch began


def area_distance(area: Area, x: float, y: float) -> float:
    """Return the distance of a point to an area [m]; 0 within."""
    return math.hypot(max(area.x_min - x, 0.0, x - area.x_max), max(area.y_min - y, 0.0, y - area.y_max))


def area_depth(area: Area, x: float, y: float) -> float:
    """Return the distance of a point within an area to its border [m]."""
    return min(x - area.x_min, area.x_max - x, y - area.y_min, area.y_max - y)


def tilt_of(orientation: Quaternion) -> float:
    """Return the angle between the z axis of a frame and the vertical [rad]."""
    _, x, y, _ = orientation
    return 2.0 * math.asin(min(math.hypot(x, y), 1.0))


@dataclass(frozen=True)
class MeasureWatch(Watch):
    """True when a measure of an entity has reached a limit; never while the entity is unknown.

    `total` sums the path [m], the ticks in the area, or the work [J] since the watch began, up to `tick`. `value`
    is the measure in that tick, in its unit, and `nearest` its least distance to the limit so far.
    """

    entity: str
    limit: MeasureLimit
    tick: int
    position: tuple[float, float]  # [m] at that tick
    work: float = 0.0  # of the robot's motors up to that tick [J]
    total: float = 0.0
    value: float | None = None
    nearest: float | None = None

    @property
    def margin(self) -> float | None:
        """Least distance of the measure to the limit, negative beyond it; None if it was never known."""
        return self.nearest

    @property
    def watched_robot(self) -> str | None:
        """Robot of a measure that only robots have."""
        return self.entity if self.limit.measure in ONLY_ROBOTS else None

    def updated(self, world: Watched) -> MeasureWatch:
        """Return the watch with the sum and the measure of the present tick."""
        state = world.state_of(self.entity)
        if state is None:
            return replace(self, value=None)
        watch = self._summed(world, state) if self.limit.measure in SUMS else self
        found = watch._measured(world, state)
        if found is None:
            return replace(watch, value=None)
        distance = watch._distance(found[0], state)
        nearest = distance if self.nearest is None else min(self.nearest, distance)
        return replace(watch, value=found[0], nearest=nearest)

    def _summed(self, world: Watched, state: BodyState) -> MeasureWatch:
        x, y, _ = state.position
        work = world.work(self.entity) or 0.0
        match self.limit.measure:
            case Measure.PATH_LENGTH:
                added = math.dist((x, y), self.position)
            case Measure.WORK:
                added = work - self.work
            case _:
                added = world.tick - self.tick if area_distance(self.limit.area, x, y) == 0.0 else 0.0
        return replace(self, tick=world.tick, position=(x, y), work=work, total=self.total + added)

    def holds(self, world: Watched) -> bool:
        """Whether the limit is reached."""
        if self.value is None:
            return False
        return self.value > self.limit.value if self.limit.above else self.value <= self.limit.value

    def rebased(self, before: Watched, now: Watched) -> MeasureWatch:
        """Return the watch with the same sum, from the present position."""
        state = now.state_of(self.entity)
        place = self.position if state is None else state.position[:2]
        if self.limit.measure is Measure.WORK:
            now.measure_work(self.entity)
        work = now.work(self.entity) or 0.0
        return replace(self, tick=now.tick, position=(place[0], place[1]), work=work)

    def result(self, world: Watched) -> tuple[Outcome, str]:
        """Return a text with the value, the other entity, place and time."""
        state = world.state_of(self.entity)
        found = None if state is None else self._measured(world, state)
        assert state is not None and found is not None, "it holds"
        value, other = found
        unit, measure = UNITS[self.limit.measure], self.limit.measure
        name = "distance from the area" if measure is Measure.AREA_DISTANCE else measure.replace("_", " ")
        whom = f" to '{other}'" if other else ""
        where = f"({state.position[0]:.3f}, {state.position[1]:.3f}) m"
        expected = "at most" if self.limit.above else "more than"
        message = (
            f"{self.entity} has a {name} of {value:.3f} {unit}{whom} at {where}, {world.time:.3f} s "
            f"after the start; expected {expected} {self.limit.value:g} {unit}"
        )
        return Outcome.SUCCEEDED, message

    def _distance(self, value: float, state: BodyState) -> float:
        """Return the distance of a value to the limit, negative beyond it; within areas, to their border."""
        if self.limit.measure is Measure.AREA_DISTANCE and value == 0.0:
            value = -area_depth(self.limit.area, state.position[0], state.position[1])
        return self.limit.value - value if self.limit.above else value - self.limit.value

    def _measured(self, world: Watched, state: BodyState) -> tuple[float, str] | None:
        """Return the value, and the other entity of a clearance; None while the value is unknown."""
        (x, y, _), area = state.position, self.limit.area
        match self.limit.measure:
            case Measure.CLEARANCE:
                clearance = world.clearance(self.entity, self.limit.other)
                return None if clearance is None else (clearance.distance, clearance.entity)
            case Measure.LOCALIZATION_ERROR:
                error = world.localization_error(self.entity)
                return None if error is None else (error, "")
            case Measure.SPEED:
                within = area_distance(area, x, y) == 0.0
                return (math.hypot(state.linear[0], state.linear[1]) if within else 0.0), ""
            case Measure.AREA_DISTANCE:
                return area_distance(area, x, y), ""
            case Measure.TILT:
                return tilt_of(state.orientation), ""
            case Measure.PATH_LENGTH | Measure.WORK:
                return self.total, ""
            case Measure.TIME_IN_AREA:
                return self.total * TICK, ""
            case _:
                assert_never(self.limit.measure)
