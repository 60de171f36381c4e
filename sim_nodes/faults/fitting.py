"""Which faults a sensor or a camera can have, and what they may say."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, assert_never

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    CameraFault,
    DeadArea,
    DeadBeams,
    DeadPixels,
    DeadSector,
    Delay,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    Quantity,
    Result,
    SensorFault,
    WheelSlip,
)
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.faults.motors import LEAST_SLIP
from sim_nodes.sensors.beams import dead_beams, lost_beams
from sim_nodes.sensors.pixels import BRIGHTEST
from sim_nodes.sensors.sensor import Sensor
from sim_nodes.ticks import TICK
from sim_nodes.views import Lens

LONGEST_DELAY = 10.0  # [s]
CAMERA_QUANTITIES = (Quantity.BRIGHTNESS,)
LEAST_DEVIATION = 0.1  # [levels of brightness]; errors of less are rounded to nothing
LEAST_OFFSET = 0.51  # the same


def check_fault(fault: SensorFault, device: str, sensor: Sensor[Any]) -> None:
    """Refuse faults that a sensor cannot have.

    Raises:
        RequestRefused: The message says why, and what would be right.
    """
    match fault:
        case GaussianNoise(deviation=deviation):
            _check_quantities(fault.kind, deviation, device, sensor.quantities)
            _check_deviations(deviation)
        case Bias(offset=offset):
            _check_quantities(fault.kind, offset, device, sensor.quantities)
            _check_offsets(offset)
        case BeamLoss(share=share):
            _check_beams(fault.kind, device, sensor)
            _check_share("share", share)
            if lost_beams(share, len(sensor.bearings)) == 0:
                raise _refused(f"a share of {share:g} of {len(sensor.bearings)} beams is not one beam")
        case DeadSector(start=start, end=end):
            _check_beams(fault.kind, device, sensor)
            if not (math.isfinite(start) and math.isfinite(end)):
                raise _refused(f"a sector has finite bearings, not {start} and {end}")
            if len(dead_beams(fault, sensor.bearings)) == 0:
                raise _refused(f"no beam lies between {start:g} and {end:g} rad: the sector is too narrow")
        case DeadBeams(beams=beams):
            _check_beams(fault.kind, device, sensor)
            last = len(sensor.bearings) - 1
            if not beams or not all(0 <= beam <= last for beam in beams):
                raise _refused(f"dead beams are one or more of the beams 0 to {last}, not {list(beams)[:20]}")
        case MessageLoss() | Delay() | Freeze() | PowerLoss():
            _check_passage(fault)
        case _:
            assert_never(fault)


def _check_passage(fault: MessageLoss | Delay | Freeze | PowerLoss) -> None:
    """Refuse faults on the way of what a device gives, whatever that is."""
    match fault:
        case MessageLoss(probability=probability):
            _check_share("probability", probability)
        case Delay(time=time):
            _check_delay(time)
        case Freeze() | PowerLoss():
            return
        case _:
            assert_never(fault)


def check_camera_fault(fault: CameraFault, device: str, lens: Lens) -> None:
    """Refuse faults that a camera cannot have.

    Raises:
        RequestRefused: The message says why, and what would be right.
    """
    match fault:
        case GaussianNoise(deviation=deviation):
            _check_quantities(fault.kind, deviation, device, CAMERA_QUANTITIES)
            _check_deviations(deviation)
            _check_levels(fault.kind, deviation, LEAST_DEVIATION)
        case Bias(offset=offset):
            _check_quantities(fault.kind, offset, device, CAMERA_QUANTITIES)
            _check_offsets(offset)
            _check_levels(fault.kind, offset, LEAST_OFFSET)
        case DeadPixels(share=share):
            _check_share("share", share)
            if lost_beams(share, lens.width * lens.height) == 0:
                raise _refused(f"a share of {share:g} of {lens.width * lens.height} pixels is not one pixel")
        case DeadArea():
            _check_area(fault, lens)
        case MessageLoss() | Delay() | Freeze() | PowerLoss():
            _check_passage(fault)
        case _:
            assert_never(fault)


def _check_levels(kind: str, amounts: Mapping[Quantity, float], least: float) -> None:
    amount = amounts[Quantity.BRIGHTNESS]
    if abs(amount) * BRIGHTEST < least:
        raise _refused(
            f"{kind} of brightness by {amount:g} is rounded to nothing: "
            f"it has to be {least / BRIGHTEST:.1g} at least"
        )


def _check_area(fault: DeadArea, lens: Lens) -> None:
    said = f"from {fault.left:g} to {fault.right:g} across and from {fault.top:g} to {fault.bottom:g} down"
    sides = ((fault.left, fault.right), (fault.top, fault.bottom))
    if not all(0.0 <= low < high <= 1.0 for low, high in sides):
        raise _refused(f"an area lies within 0 and 1, its end behind its beginning, not {said}")
    if not all(
        math.ceil(low * pixels - 0.5) <= high * pixels - 0.5
        for (low, high), pixels in zip(sides, (lens.width, lens.height), strict=True)
    ):
        raise _refused(f"no pixel lies {said}: the area is too small")


def check_slip(fault: WheelSlip) -> None:
    """Refuse slips that make no sense.

    Raises:
        RequestRefused: The message says why.
    """
    slips = (fault.left, fault.right)
    if not all(slip == 0.0 or LEAST_SLIP <= slip <= 1.0 for slip in slips) or slips == (0.0, 0.0):
        raise _refused(
            f"a slip of {fault.left:g} and {fault.right:g}: each is 0, or from {LEAST_SLIP:g} on, below which it "
            "cannot be measured, up to 1; and not both are 0"
        )


def check_most(fault: SensorFault, most: float) -> None:
    """Refuse faults by which values would be off by more than can be.

    Raises:
        RequestRefused: The message says how much can be.
    """
    match fault:
        case GaussianNoise(deviation=amounts) | Bias(offset=amounts):
            if any(abs(amount) > most for amount in amounts.values()):
                raise _refused(f"{fault.kind} of {_said(amounts)} is too much: commands may be off by {most:g}")
        case _:
            return


def _check_quantities(
    kind: str, amounts: Mapping[Quantity, float], device: str, quantities: Sequence[Quantity]
) -> None:
    known = f"it can be of {', '.join(quantities)}" if quantities else "there are no values that could be off"
    strange = [quantity for quantity in amounts if quantity not in quantities]
    if strange:
        raise _refused(f"{device} cannot have {kind} of {', '.join(strange)}: {known}")
    if not all(math.isfinite(amount) for amount in amounts.values()):
        raise _refused(f"{kind} of {_said(amounts)} has a part that is no finite number")


def _check_deviations(deviation: Mapping[Quantity, float]) -> None:
    if any(std < 0.0 for std in deviation.values()) or not any(deviation.values()):
        raise _refused(f"deviations are zero or more, and not all of them zero: {_said(deviation)}")


def _check_offsets(offset: Mapping[Quantity, float]) -> None:
    if not any(offset.values()):
        raise _refused("a bias of nothing is none: give it an offset other than zero")


def _check_delay(time: float) -> None:
    if not TICK <= time <= LONGEST_DELAY:
        raise _refused(f"a delay lasts from {TICK:g} s to {LONGEST_DELAY:g} s, not {time:g} s")


def _check_beams(kind: str, device: str, sensor: Sensor[Any]) -> None:
    if len(sensor.bearings) == 0:
        raise _refused(f"{device} cannot have {kind}: it has no beams")


def _check_share(what: str, value: float) -> None:
    if not 0.0 < value <= 1.0:
        raise _refused(f"the {what} is {value:g}: it has to be above 0, and 1 at most")


def _said(amounts: Mapping[Quantity, float]) -> str:
    return ", ".join(f"{quantity} {amount:g}" for quantity, amount in amounts.items()) or "nothing"


def _refused(message: str) -> RequestRefused:
    return RequestRefused(Result.OPERATION_FAILED, message)
