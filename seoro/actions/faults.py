"""Actions of `osc.faults`: faults of sensors and motors, injected while a robot runs.

The backend measures that a fault takes effect; what was measured stands in the trace.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from seoro.actions.reports import finish
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Faults
from seoro.runtime.context import ActionContext, Occasion
from seoro.runtime.device_faults import (
    Amounts,
    BeamLoss,
    Bias,
    DeadBeams,
    DeadSector,
    Delay,
    Fault,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    WheelSlip,
)
from seoro.runtime.values import Actor


@action("robot.inject_noise", home=Faults)
async def inject_noise(
    ctx: ActionContext,
    robot: Actor,
    device: str,
    length_deviation: float,
    angle_deviation: float,
    acceleration_deviation: float,
    angular_rate_deviation: float,
    confirm_within: float,
) -> None:
    """Add normally distributed errors to the values of a sensor."""
    deviation = Amounts(length_deviation, angle_deviation, acceleration_deviation, angular_rate_deviation)
    await _inject(ctx, robot, device, GaussianNoise(deviation), confirm_within)


@action("robot.inject_bias", home=Faults)
async def inject_bias(
    ctx: ActionContext,
    robot: Actor,
    device: str,
    length_offset: float,
    angle_offset: float,
    acceleration_offset: float,
    angular_rate_offset: float,
    confirm_within: float,
) -> None:
    """Add the same error to all values of a sensor."""
    offset = Amounts(length_offset, angle_offset, acceleration_offset, angular_rate_offset)
    await _inject(ctx, robot, device, Bias(offset), confirm_within)


@action("robot.inject_beam_loss", home=Faults)
async def inject_beam_loss(
    ctx: ActionContext, robot: Actor, share: float, device: str, confirm_within: float
) -> None:
    """Let a share of the beams see nothing, others in each scan."""
    await _inject(ctx, robot, device, BeamLoss(share), confirm_within)


@action("robot.inject_dead_sector", home=Faults)
async def inject_dead_sector(
    ctx: ActionContext,
    robot: Actor,
    from_bearing: float,
    to_bearing: float,
    device: str,
    confirm_within: float,
) -> None:
    """Let the beams between two bearings see nothing."""
    await _inject(ctx, robot, device, DeadSector(from_bearing, to_bearing), confirm_within)


@action("robot.inject_dead_beams", home=Faults)
async def inject_dead_beams(
    ctx: ActionContext, robot: Actor, beams: Sequence[int], device: str, confirm_within: float
) -> None:
    """Let some beams see nothing."""
    await _inject(ctx, robot, device, DeadBeams(beams), confirm_within)


@action("robot.inject_message_loss", home=Faults)
async def inject_message_loss(
    ctx: ActionContext, robot: Actor, device: str, probability: float, confirm_within: float
) -> None:
    """Lose samples of a sensor at random."""
    await _inject(ctx, robot, device, MessageLoss(probability), confirm_within)


@action("robot.inject_freeze", home=Faults)
async def inject_freeze(ctx: ActionContext, robot: Actor, device: str, confirm_within: float) -> None:
    """Let a sensor say the same again and again."""
    await _inject(ctx, robot, device, Freeze(), confirm_within)


@action("robot.inject_delay", home=Faults)
async def inject_delay(ctx: ActionContext, robot: Actor, device: str, delay: float, confirm_within: float) -> None:
    """Let the samples of a sensor come late."""
    await _inject(ctx, robot, device, Delay(delay), confirm_within)


@action("robot.inject_wheel_slip", home=Faults)
async def inject_wheel_slip(
    ctx: ActionContext, robot: Actor, left: float, right: float, confirm_within: float
) -> None:
    """Let wheels turn without moving the robot, by shares of what they turn."""
    await _inject(ctx, robot, "motors", WheelSlip(left, right), confirm_within)


@action("robot.inject_power_loss", home=Faults)
async def inject_power_loss(ctx: ActionContext, robot: Actor, device: str, confirm_within: float) -> None:
    """Cut off the power of a device."""
    await _inject(ctx, robot, device, PowerLoss(), confirm_within)


@action("robot.clear_faults", home=Faults)
async def clear_faults(ctx: ActionContext, robot: Actor, device: str) -> None:
    """Clear the faults of a device, or of all devices."""
    faults, name = ctx.home(robot, Faults)
    await ctx.ask(faults.clear_faults(name, device))


@action("robot.hold_faults", home=Faults, open_ended=True)
async def hold_faults(ctx: ActionContext, robot: Actor, device: str) -> None:
    """Wait, and clear the faults of a device, or of all devices, at the end."""
    faults, name = ctx.home(robot, Faults)
    try:
        await ctx.wait_for(Occasion())  # which nothing brings about
    finally:
        await ctx.ask(faults.clear_faults(name, device))


async def _inject(ctx: ActionContext, robot: Actor, device: str, fault: Fault, limit: float) -> None:
    faults, name = ctx.home(robot, Faults)
    await inject(ctx, faults, name, device, fault, limit)


async def inject(ctx: ActionContext, faults: Faults, robot: str, device: str, fault: Fault, limit: float) -> None:
    """Inject a fault, wait until it has been measured to take effect, and write down what was measured.

    Raises:
        ActionFailed: It was not found to take effect within `limit` [s]; then it is cleared.
    """
    report = await finish(ctx, partial(faults.inject_fault, robot, device, fault, limit), faults.cancel_fault)
    ctx.log(report.message)
