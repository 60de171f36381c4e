"""Actions of `osc.buildings`: doors and lifts of a simulator.

An actor is the door or lift of its own name, or the one in its field `entity`.
"""

from __future__ import annotations

from functools import partial

from seoro.actions.people import name_of
from seoro.actions.reports import finish
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.buildings import Doors, Lifts
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

MOTOR = "motor"  # one motion at a time


@action("door.open", anywhere=Doors, uses=MOTOR)
async def open_door(ctx: ActionContext, door: Actor, opening: float) -> None:
    """Open the door."""
    await _move(ctx, door, opening)


@action("door.close", anywhere=Doors, uses=MOTOR)
async def close_door(ctx: ActionContext, door: Actor) -> None:
    """Close the door."""
    await _move(ctx, door, 0.0)


@action("door.lock", anywhere=Doors, uses=MOTOR)
async def lock_door(ctx: ActionContext, door: Actor) -> None:
    """Lock the door."""
    await ctx.ask(ctx.anywhere(Doors).lock_door(name_of(door), locked=True))


@action("door.unlock", anywhere=Doors)
async def unlock_door(ctx: ActionContext, door: Actor) -> None:
    """Unlock the door."""
    await ctx.ask(ctx.anywhere(Doors).lock_door(name_of(door), locked=False))


@action("door.wait_until_open", anywhere=Doors)
async def wait_until_open(ctx: ActionContext, door: Actor, at_least: float) -> None:
    """Wait until the door is open."""
    await _wait(ctx, door, at_least, 1.0)


@action("door.wait_until_closed", anywhere=Doors)
async def wait_until_closed(ctx: ActionContext, door: Actor) -> None:
    """Wait until the door is closed."""
    await _wait(ctx, door, 0.0, 0.0)


@action("lift.move_to_floor", anywhere=Lifts, uses=MOTOR)
async def move_to_floor(ctx: ActionContext, lift: Actor, floor: int) -> None:
    """Move to a floor."""
    lifts = ctx.anywhere(Lifts)
    await finish(ctx, partial(lifts.move_lift, name_of(lift), floor), lifts.cancel_goal)


@action("lift.wait_until_at_floor", anywhere=Lifts)
async def wait_until_at_floor(ctx: ActionContext, lift: Actor, floor: int) -> None:
    """Wait until the lift is at a floor."""
    lifts = ctx.anywhere(Lifts)
    await finish(ctx, partial(lifts.watch_lift, name_of(lift), floor), lifts.cancel_watch)


async def _move(ctx: ActionContext, door: Actor, opening: float) -> None:
    doors = ctx.anywhere(Doors)
    await finish(ctx, partial(doors.move_door, name_of(door), opening), doors.cancel_goal)


async def _wait(ctx: ActionContext, door: Actor, least: float, most: float) -> None:
    doors = ctx.anywhere(Doors)
    await finish(ctx, partial(doors.watch_door, name_of(door), least, most), doors.cancel_watch)
