"""`osc.sim`: the simulator by the terms of ROS `simulation_interfaces`, and contacts in it.

`set_simulation_state` and `unload_world` are not among them: a run grants its simulator every step of time, so
that there is nothing that a scenario could pause or play, and without a world no time would pass.
"""

from __future__ import annotations

from collections.abc import Sequence

from seoro.errors import ActionFailed
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Simulation, Worlds
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Child, Interrupt, ModifierContext, Pose3D, Velocity6D
from seoro.runtime.modifiers import modifier
from seoro.runtime.values import Struct
from seoro.runtime.verdict import Outcome, Status


@action("spawn_entity", anywhere=Simulation, uris=("uri",))
async def spawn_entity(
    ctx: ActionContext,
    entity_name: str,
    uri: str,
    initial_pose: Pose3D,
    allow_renaming: bool,
    entity_namespace: str,
) -> None:
    """Spawn an entity."""
    if entity_namespace:
        raise ActionFailed("`entity_namespace` is for models with ROS 2 topics of their own; leave it out here")
    simulation = ctx.anywhere(Simulation)
    await ctx.ask(simulation.spawn_entity(entity_name, uri, initial_pose, allow_renaming=allow_renaming))


@action("delete_entity", anywhere=Simulation)
async def delete_entity(ctx: ActionContext, entity: str) -> None:
    """Delete an entity."""
    await ctx.ask(ctx.anywhere(Simulation).delete_entity(entity))


@action("set_entity_state", anywhere=Simulation)
async def set_entity_state(
    ctx: ActionContext, entity: str, pose: Pose3D, twist: Velocity6D, acceleration: Struct
) -> None:
    """Put an entity somewhere, with a velocity."""
    parts = [part for part in acceleration.fields.values() if isinstance(part, Struct)]
    if any(value for part in parts for value in part.fields.values()):
        raise ActionFailed("an acceleration cannot be set here; leave it out")
    await ctx.ask(ctx.anywhere(Simulation).set_entity_state(entity, pose, twist))


@action("reset_simulation", anywhere=Simulation)
async def reset_simulation(ctx: ActionContext) -> None:
    """Put the world back to its initial state; the time of the run goes on."""
    await ctx.ask(ctx.anywhere(Simulation).reset_simulation())


@action("load_world", anywhere=Worlds, uris=("uri",))
async def load_world(ctx: ActionContext, uri: str) -> None:
    """Go on in another world; the time of the run goes on."""
    await ctx.ask(ctx.anywhere(Worlds).change_world(uri))


@action("step_simulation", anywhere=Simulation)
async def step_simulation(ctx: ActionContext, steps: int) -> None:
    """Make physics steps while paused."""
    await ctx.ask(ctx.anywhere(Simulation).step_simulation(steps))


# ---------------------------------------------------------------- contacts


@modifier("allow_contact")
async def allow_contact(ctx: ModifierContext, child: Child, entities: Sequence[str]) -> Outcome:
    """Let robots touch entities within the behavior; anything if none is named."""
    with ctx.allow_contact(entities):
        outcome = await child.run()
    assert outcome is not None, "it has no limit"
    return outcome


@modifier("forbid_contact")
async def forbid_contact(
    ctx: ModifierContext, child: Child, robots: Sequence[str], allowed: Sequence[str], also_struck: bool
) -> Outcome:
    """Fail as soon as a robot strikes something that is not allowed."""
    found = Interrupt()
    with ctx.forbid_contact(robots, allowed, found, also_struck=also_struck):
        outcome = await child.run(interrupt=found)
    return Outcome(Status.FAILED, found.reason) if outcome is None else outcome
