"""Faults of sensors, cameras and motors; see `Faults`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.robotics.faults import Fault
from seoro.runtime.contracts.backends import Reporter


class FaultRequests(Requests):
    """The capability `Faults` of a node."""

    _features: wire.SimulatorFeatures

    def devices(self) -> Mapping[str, Sequence[str]]:
        """See `Faults`."""
        return {robot.name: robot.devices for robot in self._features.robots}

    async def inject_fault(self, robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        """See `Faults`."""
        request = wire.InjectFault(id=self.new_id("fault"), robot=robot, device=device, fault=fault, limit=limit)
        return await self.start(wire.INJECT_FAULT, request, report)

    async def cancel_fault(self, measurement: str) -> None:
        """See `Faults`."""
        await self.cancel_report(wire.CANCEL_GOAL, wire.CancelGoal(id=measurement), measurement)

    async def clear_faults(self, robot: str, device: str, fault: type[Fault] | None = None) -> None:
        """See `Faults`."""
        kind = "" if fault is None else fault.kind
        await self.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=robot, device=device, kind=kind))
