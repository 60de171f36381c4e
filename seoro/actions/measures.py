"""`osc.measures`: limits of measures as modifiers and conditions, and measurements as values."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from seoro.actions.reports import finish
from seoro.errors import ActionFailed
from seoro.lang.plan import PrimitiveType
from seoro.robotics.measures import Area, Measure, MeasureLimit
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import Report
from seoro.runtime.contracts.measures import Measuring
from seoro.runtime.contracts.modifiers import Child, Interrupt, ModifierContext
from seoro.runtime.functions.actions import action
from seoro.runtime.functions.modifiers import modifier
from seoro.runtime.values.values import Variable
from seoro.runtime.verdict import Outcome, Status

WHOLE = (PrimitiveType("int"), PrimitiveType("uint"))

# ---------------------------------------------------------------- monitors


@modifier("keep_clearance")
async def keep_clearance(
    ctx: ModifierContext, child: Child, distance: float, other: str, robots: Sequence[str]
) -> Outcome:
    """Fail as soon as a robot comes nearer to an entity."""
    return await _monitor(ctx, child, robots, MeasureLimit(Measure.CLEARANCE, distance, above=False, other=other))


@modifier("limit_speed")
async def limit_speed(
    ctx: ModifierContext, child: Child, max_speed: float, within: Area, entities: Sequence[str]
) -> Outcome:
    """Fail as soon as an entity is faster within an area."""
    return await _monitor(ctx, child, entities, MeasureLimit(Measure.SPEED, max_speed, above=True, area=within))


@modifier("limit_localization_error")
async def limit_localization_error(
    ctx: ModifierContext, child: Child, max_error: float, robots: Sequence[str]
) -> Outcome:
    """Fail as soon as the estimate of a robot is farther from the truth."""
    return await _monitor(ctx, child, robots, MeasureLimit(Measure.LOCALIZATION_ERROR, max_error, above=True))


@modifier("stay_in")
async def stay_in(ctx: ModifierContext, child: Child, within: Area, entities: Sequence[str]) -> Outcome:
    """Fail as soon as an entity is outside of an area."""
    return await _monitor(ctx, child, entities, _outside(within))


@modifier("keep_out_of")
async def keep_out_of(ctx: ModifierContext, child: Child, within: Area, entities: Sequence[str]) -> Outcome:
    """Fail as soon as an entity is within an area."""
    return await _monitor(ctx, child, entities, _inside(within))


@modifier("limit_path_length")
async def limit_path_length(
    ctx: ModifierContext, child: Child, max_length: float, entities: Sequence[str]
) -> Outcome:
    """Fail as soon as the path of an entity is longer."""
    return await _monitor(ctx, child, entities, MeasureLimit(Measure.PATH_LENGTH, max_length, above=True))


@modifier("limit_time_in")
async def limit_time_in(
    ctx: ModifierContext, child: Child, max_time: float, within: Area, entities: Sequence[str]
) -> Outcome:
    """Fail as soon as an entity has been within an area for longer."""
    return await _monitor(
        ctx, child, entities, MeasureLimit(Measure.TIME_IN_AREA, max_time, above=True, area=within)
    )


@modifier("limit_tilt")
async def limit_tilt(ctx: ModifierContext, child: Child, max_tilt: float, entities: Sequence[str]) -> Outcome:
    """Fail as soon as an entity leans farther from the vertical."""
    return await _monitor(ctx, child, entities, MeasureLimit(Measure.TILT, max_tilt, above=True))


@modifier("limit_work")
async def limit_work(ctx: ModifierContext, child: Child, max_work: float, robots: Sequence[str]) -> Outcome:
    """Fail as soon as the motors of a robot have done more mechanical work."""
    return await _monitor(ctx, child, robots, MeasureLimit(Measure.WORK, max_work, above=True))


async def _monitor(ctx: ModifierContext, child: Child, entities: Sequence[str], limit: MeasureLimit) -> Outcome:
    """Run a behavior, and fail it as soon as a measure of an entity reaches a limit."""
    reached = Interrupt()
    watches: list[tuple[Measuring, str, str]] = []  # with the entity and the id

    def report(name: str, found: Report) -> None:
        if found.margin is not None:
            ctx.record_margin(found.margin, limit.value, name)
        reached.trigger(found.message)

    try:
        for backend, name in ctx.measuring(entities):
            watch = await ctx.ask(backend.watch_measure(name, limit, partial(report, name)))
            watches.append((backend, name, watch))
        outcome = await child.run(interrupt=reached)
    finally:
        for backend, name, watch in watches:
            margin = await ctx.ask(backend.end_measure_watch(watch))
            if margin is not None:
                ctx.record_margin(margin, limit.value, name)
    return Outcome(Status.FAILED, reached.reason) if outcome is None else outcome


# ---------------------------------------------------------------- conditions


@action("wait_for_clearance", anywhere=Measuring)
async def wait_for_clearance(ctx: ActionContext, robot_name: str, at_most: float, other: str) -> None:
    """Wait until a robot is near an entity."""
    await _wait(ctx, robot_name, MeasureLimit(Measure.CLEARANCE, at_most, above=False, other=other))


@action("wait_for_speed", anywhere=Measuring)
async def wait_for_speed(ctx: ActionContext, entity: str, above: float) -> None:
    """Wait until an entity is faster."""
    await _wait(ctx, entity, MeasureLimit(Measure.SPEED, above, above=True))


@action("wait_for_slowness", anywhere=Measuring)
async def wait_for_slowness(ctx: ActionContext, entity: str, at_most: float) -> None:
    """Wait until an entity is slow."""
    await _wait(ctx, entity, MeasureLimit(Measure.SPEED, at_most, above=False))


@action("wait_for_entry", anywhere=Measuring)
async def wait_for_entry(ctx: ActionContext, entity: str, within: Area) -> None:
    """Wait until an entity is within an area."""
    await _wait(ctx, entity, _inside(within))


@action("wait_for_exit", anywhere=Measuring)
async def wait_for_exit(ctx: ActionContext, entity: str, within: Area) -> None:
    """Wait until an entity is outside of an area."""
    await _wait(ctx, entity, _outside(within))


@action("wait_for_localization_error", anywhere=Measuring)
async def wait_for_localization_error(ctx: ActionContext, robot_name: str, above: float) -> None:
    """Wait until the estimate of a robot is far from the truth."""
    await _wait(ctx, robot_name, MeasureLimit(Measure.LOCALIZATION_ERROR, above, above=True))


async def _wait(ctx: ActionContext, entity: str, limit: MeasureLimit) -> None:
    """Wait until a measure of an entity reaches a limit."""
    backend = ctx.by_name(entity, Measuring)
    await finish(ctx, partial(backend.watch_measure, entity, limit), backend.cancel_watch)


# ---------------------------------------------------------------- values


@action("store_measurement", anywhere=Measuring)
async def store_measurement(
    ctx: ActionContext, entity: str, measurement: str, target_variable: Variable[float]
) -> None:
    """Store a measurement in a variable."""
    value = await ctx.ask(ctx.by_name(entity, Measuring).measurement(entity, measurement))
    if value is None:
        raise ActionFailed(f"'{entity}' has no {measurement} yet")
    is_whole = target_variable.type in WHOLE
    if is_whole and value != int(value):
        raise ActionFailed(f"{measurement} is {value:g}; expected a variable of float or of a physical type")
    ctx.update(target_variable, lambda _: int(value) if is_whole else float(value))


def _inside(area: Area) -> MeasureLimit:
    """Return the limit that an entity reaches in an area."""
    return MeasureLimit(Measure.AREA_DISTANCE, 0.0, above=False, area=area)


def _outside(area: Area) -> MeasureLimit:
    """Return the limit that an entity reaches outside of an area."""
    return MeasureLimit(Measure.AREA_DISTANCE, 0.0, above=True, area=area)
