"""Contract of backends whose robots have sensors."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from seoro.runtime.contracts.backends import Reporter


@runtime_checkable
class Sensors(Protocol):
    """Sensors of robots. `robot` is the name from `assign_robot`; `sensor` is a sensor of that robot.

    Watches see the samples as they arrive, with injected faults. Each returns the watch's id.
    """

    async def watch_sample(self, robot: str, sensor: str, report: Reporter) -> str:
        """Report the arrival of the next sample."""
        ...

    async def watch_bumper(self, robot: str, zone: str, entity: str, report: Reporter) -> str:
        """Report when an entity presses a zone of the bumper; empty names match any."""
        ...

    async def watch_range(
        self, robot: str, sensor: str, distance: float, start: float, end: float, report: Reporter
    ) -> str:
        """Report when a lidar measures less than `distance` [m] between two bearings [rad]."""
        ...

    async def check_rate(
        self, robot: str, sensor: str, lowest: float, highest: float, duration: float, report: Reporter
    ) -> str:
        """Report after `duration` [s] whether the rate of samples was within bounds [1/s]."""
        ...

    async def cancel_sensor_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""
        ...
