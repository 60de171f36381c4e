"""Checks that a sensor, camera or motor can have a fault, and that its values are valid."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, assert_never

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.faults.motor_checks import LEAST_SLIP
from sim_nodes.outcomes import operation_failed
from sim_nodes.sensors.sensor_pipeline import BRIGHTEST, Sensor, dead_beams, lost_beams
from sim_nodes.ticks import TICK
from sim_nodes.views import Lens

LONGEST_DELAY = 10.0  # [s]
MAX_KEPT = 128 * 1024 * 1024  # [bytes] of delayed images of a sensor
LEAST_DEVIATION = 0.1  # [levels of brightness]; smaller errors are lost by rounding
LEAST_OFFSET = 0.51  # [levels of brightness]; likewise

MISSING_PARTS = {
    wire.WheelSlip: "it has no wheels",
    wire.BeamLoss: "it has no beams",
    wire.DeadSector: "it has no beams",
    wire.DeadBeams: "it has no beams",
    wire.DeadPixels: "it has no pixels",
    wire.DeadArea: "it has no pixels",
}  # reasons for refusing faults


def cannot_have(device: str, fault: wire.Fault, reason: str = "") -> RequestRefused:
    """Return the refusal of a fault that a device cannot have."""
    return operation_failed(f"{device} cannot have {fault.kind}: {reason or MISSING_PARTS[type(fault)]}")


def check_fault(fault: wire.SensorFault, device: str, sensor: Sensor[Any]) -> None:
    """Refuse a fault that a sensor cannot have.

    Raises:
        RequestRefused: The message gives the reason and the valid values.
    """
    has_beams = len(sensor.bearings) > 0
    if isinstance(fault, wire.BeamLoss | wire.DeadSector | wire.DeadBeams) and not has_beams:
        raise cannot_have(device, fault)
    match fault:
        case wire.GaussianNoise() | wire.Bias():
            _check_errors(fault, device, sensor.quantities)
        case wire.BeamLoss(share=share):
            _check_share("share", share)
            if lost_beams(share, len(sensor.bearings)) == 0:
                raise operation_failed(
                    f"invalid share {share:g} of {len(sensor.bearings)} beams: less than one beam"
                )
        case wire.DeadSector(start=start, end=end):
            if not (math.isfinite(start) and math.isfinite(end)):
                raise operation_failed(f"invalid sector from {start} to {end}; expected finite bearings")
            if len(dead_beams(fault, sensor.bearings)) == 0:
                raise operation_failed(f"no beam is between {start:g} and {end:g} rad; expected a wider sector")
        case wire.DeadBeams(beams=beams):
            last = len(sensor.bearings) - 1
            if not beams or not all(0 <= beam <= last for beam in beams):
                raise operation_failed(
                    f"invalid dead beams {list(beams)[:20]}; expected one or more from 0 to {last}"
                )
        case wire.MessageLoss() | wire.Delay() | wire.Freeze() | wire.PowerLoss():
            _check_delivery(fault)
            if isinstance(fault, wire.Delay):
                _check_memory(fault, device, sensor)
        case _:
            assert_never(fault)


def _check_memory(fault: wire.Delay, device: str, sensor: Sensor[Any]) -> None:
    """Refuse a delay that keeps too many images."""
    kept = math.ceil(fault.time / (sensor.period * TICK)) * sensor.sample_size
    if kept > MAX_KEPT:
        raise operation_failed(
            f"delay of {device} keeps {kept / 1e6:.0f} MB of images; expected at most {MAX_KEPT / 1e6:.0f} MB: "
            "shorten it, or reduce the resolution or the rate"
        )


def _check_delivery(fault: wire.MessageLoss | wire.Delay | wire.Freeze | wire.PowerLoss) -> None:
    """Refuse invalid delivery faults."""
    match fault:
        case wire.MessageLoss(probability=probability):
            _check_share("probability", probability)
        case wire.Delay(time=time):
            if not TICK <= time <= LONGEST_DELAY:
                raise operation_failed(f"invalid delay of {time:g} s; expected {TICK:g} s to {LONGEST_DELAY:g} s")
        case wire.Freeze() | wire.PowerLoss():
            return
        case _:
            assert_never(fault)


def check_camera_fault(fault: wire.CameraFault, device: str, lens: Lens) -> None:
    """Refuse a fault that a camera cannot have.

    Raises:
        RequestRefused: The message gives the reason and the valid values.
    """
    match fault:
        case wire.GaussianNoise() | wire.Bias():
            amount = _check_errors(fault, device, (wire.Quantity.BRIGHTNESS,))[wire.Quantity.BRIGHTNESS]
            least = LEAST_DEVIATION if isinstance(fault, wire.GaussianNoise) else LEAST_OFFSET
            if abs(amount) * BRIGHTEST < least:
                raise operation_failed(
                    f"{fault.kind} of brightness by {amount:g} is lost by rounding; "
                    f"expected at least {least / BRIGHTEST:.1g}"
                )
        case wire.DeadPixels(share=share):
            _check_share("share", share)
            if lost_beams(share, lens.width * lens.height) == 0:
                raise operation_failed(
                    f"invalid share {share:g} of {lens.width * lens.height} pixels: below one pixel"
                )
        case wire.DeadArea():
            _check_area(fault, lens)
        case wire.MessageLoss() | wire.Delay() | wire.Freeze() | wire.PowerLoss():
            _check_delivery(fault)
        case _:
            assert_never(fault)


def _check_area(fault: wire.DeadArea, lens: Lens) -> None:
    shown = f"from {fault.left:g} to {fault.right:g} across and from {fault.top:g} to {fault.bottom:g} down"
    sides = ((fault.left, fault.right), (fault.top, fault.bottom))
    if not all(0.0 <= low < high <= 1.0 for low, high in sides):
        raise operation_failed(f"invalid area {shown}; expected values from 0 to 1 in increasing order")
    if not all(
        math.ceil(low * pixels - 0.5) <= high * pixels - 0.5
        for (low, high), pixels in zip(sides, (lens.width, lens.height), strict=True)
    ):
        raise operation_failed(f"no pixel is {shown}; expected a larger area")


def check_slip(fault: wire.WheelSlip) -> None:
    """Refuse an invalid slip.

    Raises:
        RequestRefused: The message gives the valid values.
    """
    slips = (fault.left, fault.right)
    if not all(slip == 0.0 or LEAST_SLIP <= slip <= 1.0 for slip in slips) or slips == (0.0, 0.0):
        raise operation_failed(
            f"invalid slip {fault.left:g} and {fault.right:g}; expected 0, or from {LEAST_SLIP:g} (less "
            "cannot be measured) to 1, and not both 0"
        )


def check_command_limit(fault: wire.SensorFault, most: float) -> None:
    """Refuse a fault whose errors exceed a maximum.

    Raises:
        RequestRefused: The message gives the maximum.
    """
    if isinstance(fault, wire.GaussianNoise | wire.Bias):
        amounts = _errors_of(fault)
        if any(abs(amount) > most for amount in amounts.values()):
            raise operation_failed(f"{fault.kind} of {_text(amounts)} is too large; expected at most {most:g}")


def _errors_of(fault: wire.GaussianNoise | wire.Bias) -> Mapping[wire.Quantity, float]:
    return fault.deviation if isinstance(fault, wire.GaussianNoise) else fault.offset


def _check_errors(
    fault: wire.GaussianNoise | wire.Bias, device: str, quantities: Sequence[wire.Quantity]
) -> Mapping[wire.Quantity, float]:
    """Refuse errors that a device cannot have; returns them by quantity."""
    amounts = _errors_of(fault)
    strange = [quantity for quantity in amounts if quantity not in quantities]
    if strange:
        known = f"quantities: {', '.join(quantities)}" if quantities else "it has no numbers"
        raise operation_failed(f"{device} cannot have {fault.kind} of {', '.join(strange)}; {known}")
    if not all(math.isfinite(amount) for amount in amounts.values()):
        raise operation_failed(f"invalid {fault.kind} of {_text(amounts)}; expected finite numbers")
    has_effect = any(amounts.values())
    if isinstance(fault, wire.GaussianNoise) and not (has_effect and min(amounts.values()) >= 0.0):
        raise operation_failed(f"invalid deviations {_text(amounts)}; expected zero or more, and not all zero")
    if not has_effect:
        raise operation_failed("invalid bias without an offset; expected an offset other than zero")
    return amounts


def _check_share(what: str, value: float) -> None:
    if not 0.0 < value <= 1.0:
        raise operation_failed(f"invalid {what} {value:g}; expected more than 0, and at most 1")


def _text(amounts: Mapping[wire.Quantity, float]) -> str:
    return ", ".join(f"{quantity} {amount:g}" for quantity, amount in amounts.items()) or "nothing"
