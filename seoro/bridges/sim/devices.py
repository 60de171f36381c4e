"""Sensors of robots, and faults of sensors, cameras and motors; see `Sensors` and `Faults`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.sim.robots import RobotRequests
from seoro.robotics.faults import Fault
from seoro.runtime.contracts.backends import Reporter


class DeviceRequests(RobotRequests):
    """The capabilities `Sensors` and `Faults` of a node."""

    features: wire.SimulatorFeatures

    async def watch_sample(self, robot: str, sensor: str, report: Reporter) -> str:
        """See `Sensors`."""
        return await self.start("watch", wire.WATCH_SENSOR, report, robot=robot, sensor=sensor)

    async def watch_bumper(self, robot: str, zone: str, entity: str, report: Reporter) -> str:
        """See `Sensors`."""
        return await self.start("watch", wire.WATCH_BUMPER, report, robot=robot, zone=zone, entity=entity)

    async def watch_range(
        self, robot: str, sensor: str, distance: float, start: float, end: float, report: Reporter
    ) -> str:
        """See `Sensors`."""
        bounds = {"distance": distance, "start": start, "end": end}
        return await self.start("watch", wire.WATCH_RANGE, report, robot=robot, sensor=sensor, **bounds)

    async def check_rate(
        self, robot: str, sensor: str, lowest: float, highest: float, duration: float, report: Reporter
    ) -> str:
        """See `Sensors`."""
        bounds = {"lowest": lowest, "highest": highest, "duration": duration}
        return await self.start("watch", wire.CHECK_RATE, report, robot=robot, sensor=sensor, **bounds)

    cancel_sensor_watch = RobotRequests.cancel_watch

    def devices(self) -> Mapping[str, Sequence[str]]:
        """See `Faults`."""
        return {robot.name: robot.devices for robot in self.features.robots}

    async def inject_fault(self, robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        """See `Faults`."""
        place = {"robot": robot, "device": device}
        return await self.start("fault", wire.INJECT_FAULT, report, **place, fault=fault, limit=limit)

    async def cancel_fault(self, measurement: str) -> None:
        """See `Faults`."""
        await self.cancel_goal(measurement)

    async def clear_faults(self, robot: str, device: str, fault: type[Fault] | None = None) -> None:
        """See `Faults`."""
        kind = "" if fault is None else fault.kind
        await self.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=robot, device=device, kind=kind))
