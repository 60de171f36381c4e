"""Actions of `osc.faults`: faults of sensors, cameras and motors, injected while a robot runs.

The backend measures the effect of each fault; the measurement is logged in the trace.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from inspect import Parameter, Signature, signature
from types import MappingProxyType
from typing import Any

from seoro.actions.cameras import check_exists, name_of
from seoro.actions.reports import finish
from seoro.robotics import faults as kinds
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.actions.pending import Notifier
from seoro.runtime.contracts.sensors import Cameras, Faults
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


class _ByQuantity:
    """Function that makes a fault from amounts by quantity, with parameters such as `length_deviation`.

    Args:
        kind: Kind of the fault.
        amount: Name of the amounts.
        quantities: Quantities that the fault affects.
    """

    def __init__(
        self,
        kind: Callable[[kinds.Amounts], kinds.Fault],
        amount: str,
        quantities: Iterable[kinds.Quantity] = kinds.Quantity,
    ) -> None:
        self._kind = kind
        self._quantities = {f"{quantity.value}_{amount}": quantity for quantity in quantities}
        self.__signature__ = Signature([_parameter(name, float) for name in self._quantities])

    def __call__(self, **amounts: float) -> kinds.Fault:
        """Make the fault; amounts of zero are left out."""
        return self._kind({each: amounts[name] for name, each in self._quantities.items() if amounts[name]})


def _parameter(name: str, hint: type) -> Parameter:
    return Parameter(name, Parameter.POSITIONAL_OR_KEYWORD, annotation=hint)


def _dead_sector(from_bearing: float, to_bearing: float) -> kinds.Fault:
    return kinds.DeadSector(from_bearing, to_bearing)


def _delay(delay: float) -> kinds.Fault:
    return kinds.Delay(delay)


_COMMON: Mapping[str, Callable[..., kinds.Fault]] = MappingProxyType(
    {
        "inject_dead_pixels": kinds.DeadPixels,
        "inject_dead_area": kinds.DeadArea,
        "inject_message_loss": kinds.MessageLoss,
        "inject_freeze": kinds.Freeze,
        "inject_delay": _delay,
        "inject_power_loss": kinds.PowerLoss,
    }
)
"""Functions by action of both robots and cameras."""

_MAKERS: Mapping[str, Callable[..., kinds.Fault]] = MappingProxyType(
    {
        **{f"{actor}.{name}": make for actor in ("robot", "camera") for name, make in _COMMON.items()},
        "robot.inject_noise": _ByQuantity(kinds.GaussianNoise, "deviation"),
        "robot.inject_bias": _ByQuantity(kinds.Bias, "offset"),
        "robot.inject_beam_loss": kinds.BeamLoss,
        "robot.inject_dead_sector": _dead_sector,
        "robot.inject_dead_beams": kinds.DeadBeams,
        "camera.inject_noise": _ByQuantity(kinds.GaussianNoise, "deviation", [kinds.Quantity.BRIGHTNESS]),
        "camera.inject_bias": _ByQuantity(kinds.Bias, "offset", [kinds.Quantity.BRIGHTNESS]),
    }
)
"""Functions by action, which return the fault for the parameters of the action."""


def _define(name: str, make: Callable[..., kinds.Fault]) -> None:
    """Define the action of a fault: its parameters are those of `make`, `device` for robots, `confirm_within`."""
    is_camera = name.startswith("camera.")

    async def inject_fault(ctx: ActionContext, actor: Actor, confirm_within: float, **values: Any) -> None:
        if is_camera:
            robot, device = await _found(ctx, actor)
            faults = ctx.anywhere(Faults)
        else:
            faults, robot = ctx.home(actor, Faults)
            device = values.pop("device")
        await inject(ctx, faults, robot, device, make(**values), confirm_within)

    hints = {"ctx": ActionContext, "actor": Actor, "confirm_within": float} | (
        {} if is_camera else {"device": str}
    )
    own = [_parameter(key, hint) for key, hint in hints.items()]
    made = [each for each in signature(make, eval_str=True).parameters.values() if each.name != "kind"]
    inject_fault.__signature__ = Signature([*own, *made])  # type: ignore[attr-defined]
    inject_fault.__name__ = inject_fault.__qualname__ = name.replace(".", "_")
    marked = action(name, anywhere=Faults) if is_camera else action(name, home=Faults)
    globals()[inject_fault.__name__] = marked(inject_fault)


for _name, _make in _MAKERS.items():
    _define(_name, _make)


@action("robot.inject_wheel_slip", home=Faults)
async def inject_wheel_slip(
    ctx: ActionContext, robot: Actor, left: float, right: float, confirm_within: float
) -> None:
    """Make the wheels slip by shares of their rotation."""
    faults, name = ctx.home(robot, Faults)
    await inject(ctx, faults, name, "motors", kinds.WheelSlip(left, right), confirm_within)


@action("robot.clear_faults", home=Faults)
async def clear_faults(ctx: ActionContext, robot: Actor, device: str) -> None:
    """Clear the faults of a device, or of all devices."""
    faults, name = ctx.home(robot, Faults)
    await ctx.ask(faults.clear_faults(name, device))


@action("robot.hold_faults", home=Faults, open_ended=True)
async def hold_faults(ctx: ActionContext, robot: Actor, device: str) -> None:
    """Wait until cancelled, then clear the faults of a device, or of all devices."""
    faults, name = ctx.home(robot, Faults)
    try:
        await ctx.wait_for(Notifier())  # never notified
    finally:
        await ctx.ask(faults.clear_faults(name, device))


@action("camera.clear_faults", anywhere=Faults)
async def clear_camera_faults(ctx: ActionContext, camera: Actor) -> None:
    """Clear the faults of a camera."""
    robot, device = await _found(ctx, camera)
    await ctx.ask(ctx.anywhere(Faults).clear_faults(robot, device))


@action("camera.hold_faults", anywhere=Faults, open_ended=True)
async def hold_camera_faults(ctx: ActionContext, camera: Actor) -> None:
    """Wait until cancelled, then clear the faults of a camera."""
    robot, device = await _found(ctx, camera)
    try:
        await ctx.wait_for(Notifier())  # never notified
    finally:
        if name_of(camera) in await ctx.ask(ctx.anywhere(Cameras).cameras()):  # it may have been removed meanwhile
            await ctx.ask(ctx.anywhere(Faults).clear_faults(robot, device))


async def _found(ctx: ActionContext, camera: Actor) -> tuple[str, str]:
    """Return the robot that carries a camera (empty for a free one) and the camera's device name."""
    await check_exists(ctx, camera)
    robot, _, device = name_of(camera).rpartition("/")
    return robot, device


async def inject(
    ctx: ActionContext, faults: Faults, robot: str, device: str, fault: kinds.Fault, limit: float
) -> None:
    """Inject a fault, wait for the measurement of its effect, and log that.

    Raises:
        ActionFailed: No effect was measured within `limit` [s]; the fault is cleared.
    """
    report = await finish(ctx, partial(faults.inject_fault, robot, device, fault, limit), faults.cancel_fault)
    ctx.log(report.message)
