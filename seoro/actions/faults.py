"""Actions of `osc.faults`: faults of sensors, cameras and motors, injected while a robot runs.

The backend measures that a fault takes effect; what was measured stands in the trace.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from seoro.actions.cameras import check_is_there, name_of
from seoro.actions.reports import finish
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Cameras, Faults
from seoro.runtime.context import ActionContext, Occasion
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
    brightness_deviation: float,
    confirm_within: float,
) -> None:
    """Add normally distributed errors to the values of a sensor."""
    deviation = Amounts(
        length_deviation,
        angle_deviation,
        acceleration_deviation,
        angular_rate_deviation,
        brightness_deviation,
    )
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
    brightness_offset: float,
    confirm_within: float,
) -> None:
    """Add the same error to all values of a sensor."""
    offset = Amounts(length_offset, angle_offset, acceleration_offset, angular_rate_offset, brightness_offset)
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


@action("robot.inject_dead_pixels", home=Faults)
async def inject_dead_pixels(
    ctx: ActionContext, robot: Actor, device: str, share: float, confirm_within: float
) -> None:
    """Let a share of the pixels of a camera be black, always the same ones."""
    await _inject(ctx, robot, device, DeadPixels(share), confirm_within)


@action("robot.inject_dead_area", home=Faults)
async def inject_dead_area(
    ctx: ActionContext,
    robot: Actor,
    device: str,
    left: float,
    top: float,
    right: float,
    bottom: float,
    confirm_within: float,
) -> None:
    """Let a rectangle of the pictures of a camera be black."""
    await _inject(ctx, robot, device, DeadArea(left, top, right, bottom), confirm_within)


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


@action("camera.inject_noise", anywhere=Faults)
async def inject_camera_noise(
    ctx: ActionContext, camera: Actor, brightness_deviation: float, confirm_within: float
) -> None:
    """Add normally distributed errors to the pixels of a camera."""
    await _spoil(ctx, camera, GaussianNoise(Amounts(brightness=brightness_deviation)), confirm_within)


@action("camera.inject_bias", anywhere=Faults)
async def inject_camera_bias(
    ctx: ActionContext, camera: Actor, brightness_offset: float, confirm_within: float
) -> None:
    """Make all pixels of a camera brighter or darker."""
    await _spoil(ctx, camera, Bias(Amounts(brightness=brightness_offset)), confirm_within)


@action("camera.inject_dead_pixels", anywhere=Faults)
async def inject_camera_dead_pixels(
    ctx: ActionContext, camera: Actor, share: float, confirm_within: float
) -> None:
    """Let a share of the pixels of a camera be black, always the same ones."""
    await _spoil(ctx, camera, DeadPixels(share), confirm_within)


@action("camera.inject_dead_area", anywhere=Faults)
async def inject_camera_dead_area(
    ctx: ActionContext,
    camera: Actor,
    left: float,
    top: float,
    right: float,
    bottom: float,
    confirm_within: float,
) -> None:
    """Let a rectangle of the pictures of a camera be black."""
    await _spoil(ctx, camera, DeadArea(left, top, right, bottom), confirm_within)


@action("camera.inject_message_loss", anywhere=Faults)
async def inject_camera_message_loss(
    ctx: ActionContext, camera: Actor, probability: float, confirm_within: float
) -> None:
    """Lose pictures of a camera at random."""
    await _spoil(ctx, camera, MessageLoss(probability), confirm_within)


@action("camera.inject_freeze", anywhere=Faults)
async def inject_camera_freeze(ctx: ActionContext, camera: Actor, confirm_within: float) -> None:
    """Let a camera give the same picture again and again."""
    await _spoil(ctx, camera, Freeze(), confirm_within)


@action("camera.inject_delay", anywhere=Faults)
async def inject_camera_delay(ctx: ActionContext, camera: Actor, delay: float, confirm_within: float) -> None:
    """Let a camera show what there was to be seen before."""
    await _spoil(ctx, camera, Delay(delay), confirm_within)


@action("camera.inject_power_loss", anywhere=Faults)
async def inject_camera_power_loss(ctx: ActionContext, camera: Actor, confirm_within: float) -> None:
    """Cut off the power of a camera."""
    await _spoil(ctx, camera, PowerLoss(), confirm_within)


@action("camera.clear_faults", anywhere=Faults)
async def clear_camera_faults(ctx: ActionContext, camera: Actor) -> None:
    """Clear the faults of a camera."""
    robot, device = await _found(ctx, camera)
    await ctx.ask(ctx.anywhere(Faults).clear_faults(robot, device))


@action("camera.hold_faults", anywhere=Faults, open_ended=True)
async def hold_camera_faults(ctx: ActionContext, camera: Actor) -> None:
    """Wait, and clear the faults of a camera at the end."""
    robot, device = await _found(ctx, camera)
    try:
        await ctx.wait_for(Occasion())  # which nothing brings about
    finally:
        if name_of(camera) in await ctx.ask(ctx.anywhere(Cameras).cameras()):  # it may have been removed meanwhile
            await ctx.ask(ctx.anywhere(Faults).clear_faults(robot, device))


async def _spoil(ctx: ActionContext, camera: Actor, fault: Fault, limit: float) -> None:
    robot, device = await _found(ctx, camera)
    await inject(ctx, ctx.anywhere(Faults), robot, device, fault, limit)


async def _found(ctx: ActionContext, camera: Actor) -> tuple[str, str]:
    """The robot that carries a camera, empty if none does, and what it is called among the devices."""
    await check_is_there(ctx, camera)
    robot, _, device = name_of(camera).rpartition("/")
    return robot, device


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
