"""Sensors of robots, and faults of sensors, cameras and motors; see `Sensors` and `Faults`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.sim.sensing import SensingRequests
from seoro.robotics.faults import Fault
from seoro.runtime.contracts.backends import Reporter


class DeviceRequests(SensingRequests):
    """The capabilities `Sensors` and `Faults` of a node."""

    features: wire.SimulatorFeatures

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
            id=self.new_id("watch"),
            robot=robot,
            sensor=sensor,
            lowest=lowest,
            highest=highest,
            duration=duration,
        )
        return await self.start(wire.CHECK_RATE, request, report)

    def devices(self) -> Mapping[str, Sequence[str]]:
        """See `Faults`."""
        return {robot.name: robot.devices for robot in self.features.robots}

    async def inject_fault(self, robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        """See `Faults`."""
        request = wire.InjectFault(id=self.new_id("fault"), robot=robot, device=device, fault=fault, limit=limit)
        return await self.start(wire.INJECT_FAULT, request, report)

    async def cancel_fault(self, measurement: str) -> None:
        """See `Faults`."""
        await self.cancel_goal(measurement)

    async def clear_faults(self, robot: str, device: str, fault: type[Fault] | None = None) -> None:
        """See `Faults`."""
        kind = "" if fault is None else fault.kind
        await self.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=robot, device=device, kind=kind))
