"""Contracts of backends that simulate doors and lifts."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from seoro.runtime.contracts.backends import Reporter


@runtime_checkable
class Doors(Protocol):
    """Doors of a simulated world, by name. An opening is 0 if the door is closed, and 1 if it is open."""

    async def move_door(self, door: str, opening: float, report: Reporter) -> str:
        """Move a door to an opening; return the id of the goal."""

    async def lock_door(self, door: str, *, locked: bool) -> None:
        """Lock a closed door, or unlock it."""

    async def watch_door(self, door: str, least: float, most: float, report: Reporter) -> str:
        """Report when the opening of a door is in a range; return the watch's id."""

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop. Goals that have ended are ignored."""

    async def cancel_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""


@runtime_checkable
class Lifts(Protocol):
    """Lifts of a simulated world, by name. Floors are numbered from 0, upwards."""

    async def move_lift(self, lift: str, floor: int, report: Reporter) -> str:
        """Move a lift to a floor; return the id of the goal."""

    async def watch_lift(self, lift: str, floor: int, report: Reporter) -> str:
        """Report when a lift is at a floor; return the watch's id."""

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop. Goals that have ended are ignored."""

    async def cancel_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""
