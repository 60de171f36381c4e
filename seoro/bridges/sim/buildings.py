"""Doors and lifts of a node; see `Doors` and `Lifts`."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.runtime.contracts.backends import Reporter


class BuildingRequests(Requests):
    """The capabilities `Doors` and `Lifts` of a node."""

    async def move_door(self, door: str, opening: float, report: Reporter) -> str:
        """See `Doors`."""
        request = wire.MoveDoor(id=self.new_id("goal"), door=door, opening=opening)
        return await self.start(wire.MOVE_DOOR, request, report)

    async def lock_door(self, door: str, *, locked: bool) -> None:
        """See `Doors`."""
        await self.ask(wire.LOCK_DOOR, wire.LockDoor(door=door, locked=locked))

    async def watch_door(self, door: str, least: float, most: float, report: Reporter) -> str:
        """See `Doors`."""
        request = wire.WatchDoor(id=self.new_id("watch"), door=door, least=least, most=most)
        return await self.start(wire.WATCH_DOOR, request, report)

    async def move_lift(self, lift: str, floor: int, report: Reporter) -> str:
        """See `Lifts`."""
        request = wire.MoveLift(id=self.new_id("goal"), lift=lift, floor=floor)
        return await self.start(wire.MOVE_LIFT, request, report)

    async def watch_lift(self, lift: str, floor: int, report: Reporter) -> str:
        """See `Lifts`."""
        request = wire.WatchLift(id=self.new_id("watch"), lift=lift, floor=floor)
        return await self.start(wire.WATCH_LIFT, request, report)
