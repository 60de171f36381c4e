"""Actions of `osc.sensors`: waiting for samples of sensors, and checking their rate."""

from __future__ import annotations

from functools import partial

from seoro.actions.reports import finish
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.sensors import ForceSensing, Sensors, SightSensing
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("robot.wait_for_sample", home=Sensors)
async def wait_for_sample(ctx: ActionContext, robot: Actor, sensor: str) -> None:
    """Wait for the next sample of a sensor."""
    sensors, name = ctx.home(robot, Sensors)
    await finish(ctx, partial(sensors.watch_sample, name, sensor), sensors.cancel_sensor_watch)


@action("robot.wait_for_bump", home=Sensors)
async def wait_for_bump(ctx: ActionContext, robot: Actor, zone: str, entity: str) -> None:
    """Wait until the bumper is pressed."""
    sensors, name = ctx.home(robot, Sensors)
    await finish(ctx, partial(sensors.watch_bumper, name, zone, entity), sensors.cancel_sensor_watch)


@action("robot.wait_for_range", home=Sensors)
async def wait_for_range(
    ctx: ActionContext, robot: Actor, nearer_than: float, from_bearing: float, to_bearing: float, sensor: str
) -> None:
    """Wait until a ranging sensor measures a distance below a limit."""
    sensors, name = ctx.home(robot, Sensors)
    watch = partial(sensors.watch_range, name, sensor, nearer_than, from_bearing, to_bearing)
    await finish(ctx, watch, sensors.cancel_sensor_watch)


@action("robot.wait_for_force", home=ForceSensing)
async def wait_for_force(ctx: ActionContext, robot: Actor, sensor: str, above: float) -> None:
    """Wait until a force-torque sensor measures a greater force."""
    sensors, name = ctx.home(robot, ForceSensing)
    await finish(ctx, partial(sensors.watch_force, name, sensor, above), sensors.cancel_sensor_watch)


@action("robot.wait_until_sees", home=SightSensing)
async def wait_until_sees(ctx: ActionContext, robot: Actor, entity: str, sensor: str, share: float) -> None:
    """Wait until a segmentation sensor sees an entity."""
    sensors, name = ctx.home(robot, SightSensing)
    await finish(ctx, partial(sensors.watch_sight, name, sensor, entity, share), sensors.cancel_sensor_watch)


@action("robot.check_rate", home=Sensors)
async def check_rate(
    ctx: ActionContext, robot: Actor, sensor: str, lowest: float, highest: float, measured_for: float
) -> None:
    """Check the rate at which samples arrive."""
    sensors, name = ctx.home(robot, Sensors)
    watch = partial(sensors.check_rate, name, sensor, lowest, highest, measured_for)
    report = await finish(ctx, watch, sensors.cancel_sensor_watch)
    ctx.log(report.message)
