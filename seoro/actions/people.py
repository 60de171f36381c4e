"""Actions of `osc.people`: people and carts of a simulator.

An actor is the person or cart of its own name, or the one in its field `entity`.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence

from seoro.actions.reports import finish
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.robotics.geometry import Pose3D
from seoro.robotics.people import Avoidance
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.people import People, Point, Traits
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

BODY = "body"  # one motion at a time


@action("pedestrian.appear", anywhere=People)
async def appear(
    ctx: ActionContext, person: Actor, pose: Pose3D, speed: float, radius: float, height: float, avoid: EnumValue
) -> None:
    """Spawn the person."""
    traits = Traits(speed, radius, height, Avoidance(avoid.member))
    await ctx.ask(ctx.anywhere(People).spawn_person(name_of(person), pose, traits))


@action("pedestrian.walk_to", anywhere=People, uses=BODY)
async def walk_to(ctx: ActionContext, person: Actor, position: Point, speed: float) -> None:
    """Walk to a position."""
    await _walk(ctx, person, (position,), speed)


@action("pedestrian.walk_to_place", anywhere=People, uses=BODY)
async def walk_to_place(ctx: ActionContext, person: Actor, place: str, speed: float) -> None:
    """Walk to a named pose of the world."""
    if not place:
        raise ActionFailed("empty `place`; expected the name of a pose of the world")
    await _walk(ctx, person, (), speed, place)


@action("pedestrian.walk_along", anywhere=People, uses=BODY)
async def walk_along(ctx: ActionContext, person: Actor, positions: Sequence[Point], speed: float) -> None:
    """Walk along positions."""
    await _walk(ctx, person, positions, speed)


@action("pedestrian.patrol", anywhere=People, uses=BODY, open_ended=True)
async def patrol(ctx: ActionContext, person: Actor, positions: Sequence[Point], speed: float) -> None:
    """Walk along positions, again and again."""
    await _walk(ctx, person, positions, speed, repeat=True)


@action("pedestrian.wander", anywhere=People, uses=BODY, open_ended=True)
async def wander(ctx: ActionContext, person: Actor, lower: Point, upper: Point, speed: float) -> None:
    """Walk between random positions."""
    people, name = ctx.anywhere(People), name_of(person)
    await _move(ctx, lambda report: people.wander(name, lower, upper, speed, report))


@action("pedestrian.follow", anywhere=People, uses=BODY, open_ended=True)
async def follow(ctx: ActionContext, person: Actor, entity: str, distance: float, speed: float) -> None:
    """Follow an entity."""
    people, name = ctx.anywhere(People), name_of(person)
    await _move(ctx, lambda report: people.walk_after(name, entity, distance, speed, report))


@action("pedestrian.stand", anywhere=People, uses=BODY)
async def stand(ctx: ActionContext, person: Actor) -> None:
    """Stop the person."""
    await ctx.ask(ctx.anywhere(People).stand_still(name_of(person)))


@action("cart.drive_along", anywhere=People, uses=BODY)
async def drive_along(ctx: ActionContext, cart: Actor, positions: Sequence[Point], speed: float) -> None:
    """Drive along positions."""
    await _walk(ctx, cart, positions, speed)


@action("cart.patrol", anywhere=People, uses=BODY, open_ended=True)
async def patrol_by_cart(ctx: ActionContext, cart: Actor, positions: Sequence[Point], speed: float) -> None:
    """Drive along positions, again and again."""
    await _walk(ctx, cart, positions, speed, repeat=True)


@action("cart.stand", anywhere=People, uses=BODY)
async def stop_cart(ctx: ActionContext, cart: Actor) -> None:
    """Stop the cart."""
    await ctx.ask(ctx.anywhere(People).stand_still(name_of(cart)))


async def _walk(
    ctx: ActionContext,
    actor: Actor,
    positions: Sequence[Point],
    speed: float,
    place: str = "",
    *,
    repeat: bool = False,
) -> None:
    people, name = ctx.anywhere(People), name_of(actor)
    await _move(ctx, lambda report: people.walk_along(name, positions, place, speed, report, repeat=repeat))


async def _move(ctx: ActionContext, start: Callable[[Reporter], Awaitable[str]]) -> None:
    """Start a motion and wait for its end."""
    await finish(ctx, start, ctx.anywhere(People).cancel_goal)


def name_of(actor: Actor) -> str:
    """Return the name of an actor's entity in the simulator."""
    entity = actor.fields["entity"]
    return entity if isinstance(entity, str) and entity else actor.name.replace(".", "_")
