"""Sensors of robots; see `Sensors`."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.runtime.contracts.backends import Reporter


class SensorRequests(Requests):
    """The capability `Sensors` of a node."""

    async def watch_sample(self, robot: str, sensor: str, report: Reporter) -> str:
        """See `Sensors`."""
        request = wire.WatchSensor(id=self.new_id("watch"), robot=robot, sensor=sensor)
        return await self.start(wire.WATCH_SENSOR, request, report)

    async def watch_bumper(self, robot: str, zone: str, entity: str, report: Reporter) -> str:
        """See `Sensors`."""
        request = wire.WatchBumper(id=self.new_id("watch"), robot=robot, zone=zone, entity=entity)
        return await self.start(wire.WATCH_BUMPER, request, report)

    async def watch_range(
        self, robot: str, sensor: str, distance: float, start: float, end: float, report: Reporter
    ) -> str:
        """See `Sensors`."""
        request = wire.WatchRange(
            id=self.new_id("watch"), robot=robot, sensor=sensor, distance=distance, start=start, end=end
        )
        return await self.start(wire.WATCH_RANGE, request, report)

    async def check_rate(
        self, robot: str, sensor: str, lowest: float, highest: float, duration: float, report: Reporter
    ) -> str:
        """See `Sensors`."""
        request = wire.CheckRate(
            id=self.new_id("watch"), robot=robot, sensor=sensor, lowest=lowest, highest=highest, duration=duration
        )
        return await self.start(wire.CHECK_RATE, request, report)

    async def cancel_sensor_watch(self, watch: str) -> None:
        """See `Sensors`."""
        await self.cancel_report(wire.CANCEL_WATCH, wire.CancelWatch(id=watch), watch)
