"""Contract of backends that measure robots and other entities."""

from __future__ import annotations

from typing import Final, Protocol, runtime_checkable

from seoro.robotics.measures import MeasureLimit
from seoro.runtime.contracts.backends import Reporter

CLOSEST_APPROACH: Final = "closest_approach"  # measurement of a robot


@runtime_checkable
class Measuring(Protocol):
    """A world in which measures are known from the truth."""

    async def watch_measure(self, entity: str, limit: MeasureLimit, report: Reporter) -> str:
        """Report when a measure of an entity reaches a limit, with its value; return the watch's id."""

    async def cancel_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""

    async def end_measure_watch(self, watch: str) -> float | None:
        """Cancel a watch of a measure; return the least distance to its limit, None if it has fired."""

    async def measurement(self, entity: str, name: str) -> float | None:
        """Return a measurement of an entity since the start of the run, by its name in `measurements.json`.

        None stands for a value that does not exist yet.
        """
