"""Contract of backends that simulate people and carts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from seoro.lang.frozen import Value
from seoro.robotics.geometry import Pose3D
from seoro.robotics.people import Avoidance
from seoro.runtime.contracts.backends import Reporter


class Point(Value):
    """A point of the map [m]."""

    x: float
    y: float


class Traits(Value):
    """Traits of a person.

    Args:
        speed: Usual speed [m/s].
        radius: Radius [m].
        height: Height [m].
        avoid: Way to avoid others.
    """

    speed: float
    radius: float
    height: float
    avoid: Avoidance


@runtime_checkable
class People(Protocol):
    """People and carts of a simulated world. `person` is the name of an entity; a `speed` of 0 is its own.

    A person with a goal refuses another one. Each motion returns the id of its goal.
    """

    async def spawn_person(self, person: str, pose: Pose3D, traits: Traits) -> None:
        """Spawn a person that stands."""

    async def walk_along(
        self, person: str, points: Sequence[Point], place: str, speed: float, report: Reporter, *, repeat: bool
    ) -> str:
        """Walk along straight lines between points, and to a named pose, unless `place` is empty.

        With `repeat`, the person starts again at the first point, without an end.
        """

    async def wander(self, person: str, lower: Point, upper: Point, speed: float, report: Reporter) -> str:
        """Walk between random points of an area, without an end."""

    async def walk_after(self, person: str, entity: str, distance: float, speed: float, report: Reporter) -> str:
        """Follow an entity at a distance [m], without an end."""

    async def stand_still(self, person: str) -> None:
        """Stand; an active goal ends as canceled."""

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stand. Goals that have ended are ignored."""
