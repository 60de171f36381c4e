"""Sensors of robots; see `Sensors` for what the methods do."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.runtime.contracts import Reporter


class SensorRequests(Requests):
    """The capability `Sensors` of a node."""

    async def watch_sample(self, robot: str, sensor: str, report: Reporter) -> str:
        """See `Sensors`."""
        number = self._expect(report)
        request = wire.WatchSensor(id=number, robot=robot, sensor=sensor)
        return await self.ask_reported(wire.WATCH_SENSOR, request, number)

    async def watch_bumper(self, robot: str, zone: str, entity: str, report: Reporter) -> str:
        """See `Sensors`."""
        number = self._expect(report)
        request = wire.WatchBumper(id=number, robot=robot, zone=zone, entity=entity)
        return await self.ask_reported(wire.WATCH_BUMPER, request, number)

    async def watch_range(
        self, robot: str, sensor: str, distance: float, start: float, end: float, report: Reporter
    ) -> str:
        """See `Sensors`."""
        number = self._expect(report)
        request = wire.WatchRange(id=number, robot=robot, sensor=sensor, distance=distance, start=start, end=end)
        return await self.ask_reported(wire.WATCH_RANGE, request, number)

    async def check_rate(
        self, robot: str, sensor: str, lowest: float, highest: float, duration: float, report: Reporter
    ) -> str:
        """See `Sensors`."""
        number = self._expect(report)
        request = wire.CheckRate(
            id=number, robot=robot, sensor=sensor, lowest=lowest, highest=highest, duration=duration
        )
        return await self.ask_reported(wire.CHECK_RATE, request, number)

    async def cancel_sensor_watch(self, watch: str) -> None:
        """See `Sensors`."""
        await self.forget(wire.CANCEL_WATCH, wire.CancelWatch(id=watch), watch)

    def _expect(self, report: Reporter) -> str:
        """The id of a new watch, whose end is told to a reporter."""
        number = self.new_id("watch")
        self._reporters[number] = report
        return number
