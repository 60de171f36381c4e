"""Faults of sensors, cameras and motors; see `Faults` for what the methods do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import assert_never

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.runtime.contracts import Reporter
from seoro.runtime.device_faults import (
    Amounts,
    BeamLoss,
    Bias,
    DeadArea,
    DeadBeams,
    DeadPixels,
    DeadSector,
    Delay,
    Fault,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    WheelSlip,
)

KINDS: Mapping[type[Fault], str] = {
    GaussianNoise: "gaussian_noise",
    Bias: "bias",
    BeamLoss: "beam_loss",
    DeadSector: "dead_sector",
    DeadBeams: "dead_beams",
    DeadPixels: "dead_pixels",
    DeadArea: "dead_area",
    MessageLoss: "message_loss",
    Freeze: "freeze",
    Delay: "delay",
    WheelSlip: "wheel_slip",
    PowerLoss: "power_loss",
}


class FaultRequests(Requests):
    """The capability `Faults` of a node."""

    _features: wire.SimulatorFeatures

    def devices(self) -> Mapping[str, Sequence[str]]:
        """See `Faults`."""
        return {robot.name: robot.devices for robot in self._features.robots}

    async def inject_fault(self, robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        """See `Faults`."""
        number = self.new_id("fault")
        request = wire.InjectFault(id=number, robot=robot, device=device, fault=fault_message(fault), limit=limit)
        self._reporters[number] = report
        return await self.ask_reported(wire.INJECT_FAULT, request, number)

    async def cancel_fault(self, measurement: str) -> None:
        """See `Faults`."""
        await self.forget(wire.CANCEL_GOAL, wire.CancelGoal(id=measurement), measurement)

    async def clear_faults(self, robot: str, device: str, fault: type[Fault] | None = None) -> None:
        """See `Faults`."""
        kind = "" if fault is None else KINDS[fault]
        await self.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=robot, device=device, kind=kind))


def fault_message(fault: Fault) -> wire.Fault:
    """A fault as it is said on the wire."""
    match fault:
        case GaussianNoise(deviation=deviation):
            return wire.GaussianNoise(deviation=_amounts(deviation))
        case Bias(offset=offset):
            return wire.Bias(offset=_amounts(offset))
        case BeamLoss(share=share):
            return wire.BeamLoss(share=share)
        case DeadSector(start=start, end=end):
            return wire.DeadSector(start=start, end=end)
        case DeadBeams(beams=beams):
            return wire.DeadBeams(beams=tuple(beams))
        case DeadPixels(share=share):
            return wire.DeadPixels(share=share)
        case DeadArea(left=left, top=top, right=right, bottom=bottom):
            return wire.DeadArea(left=left, top=top, right=right, bottom=bottom)
        case MessageLoss(probability=probability):
            return wire.MessageLoss(probability=probability)
        case Freeze():
            return wire.Freeze()
        case Delay(time=time):
            return wire.Delay(time=time)
        case WheelSlip(left=left, right=right):
            return wire.WheelSlip(left=left, right=right)
        case PowerLoss():
            return wire.PowerLoss()
        case _:
            assert_never(fault)


def _amounts(amounts: Amounts) -> dict[wire.Quantity, float]:
    """The amounts that are not zero."""
    everything = {quantity: getattr(amounts, quantity.value) for quantity in wire.Quantity}
    return {quantity: amount for quantity, amount in everything.items() if amount}
