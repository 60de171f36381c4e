"""Actions of `osc.sim`: the simulator by the terms of ROS `simulation_interfaces`.

`set_simulation_state` and `unload_world` are not among them: a run grants its simulator every step of time, so
that there is nothing that a scenario could pause or play, and without a world no time would pass.
"""

from __future__ import annotations

from seoro.errors import ActionFailed
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Simulation, Worlds
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Pose3D, Velocity6D
from seoro.runtime.values import Struct


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
