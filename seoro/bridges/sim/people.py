"""People and carts of a node; see `People`."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.sim.robots import RobotRequests
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.people import Point, Traits


class PeopleRequests(RobotRequests):
    """The capability `People` of a node."""

    async def spawn_person(self, person: str, pose: Pose3D, traits: Traits) -> None:
        """See `People`."""
        request = wire.SpawnPerson(
            name=person,
            pose=pose,
            speed=traits.speed,
            radius=traits.radius,
            height=traits.height,
            avoid=traits.avoid,
        )
        await self.ask(wire.SPAWN_PERSON, request)

    async def walk_along(
        self, person: str, points: Sequence[Point], place: str, speed: float, report: Reporter, *, repeat: bool
    ) -> str:
        """See `People`."""
        request = wire.WalkAlong(
            id=self.new_id("goal"),
            person=person,
            points=tuple(Position3D(point.x, point.y) for point in points),
            place=place,
            speed=speed,
            repeat=repeat,
        )
        return await self.start(wire.WALK_ALONG, request, report)

    async def wander(self, person: str, lower: Point, upper: Point, speed: float, report: Reporter) -> str:
        """See `People`."""
        request = wire.Wander(
            id=self.new_id("goal"),
            person=person,
            lower=Position3D(lower.x, lower.y),
            upper=Position3D(upper.x, upper.y),
            speed=speed,
        )
        return await self.start(wire.WANDER, request, report)

    async def walk_after(self, person: str, entity: str, distance: float, speed: float, report: Reporter) -> str:
        """See `People`."""
        request = wire.WalkAfter(
            id=self.new_id("goal"), person=person, entity=entity, distance=distance, speed=speed
        )
        return await self.start(wire.WALK_AFTER, request, report)

    async def stand_still(self, person: str) -> None:
        """See `People`."""
        await self.ask(wire.STAND_STILL, wire.PersonName(person=person))
