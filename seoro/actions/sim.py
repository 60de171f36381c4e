"""`osc.sim`: the simulator in terms of ROS `simulation_interfaces`, and contacts.

`set_simulation_state` and `unload_world` are not supported: a run grants the simulator each step of time, so a
scenario cannot pause it, and without a world no time would pass.
"""

from __future__ import annotations

from collections.abc import Sequence

from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D, Velocity6D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.modifiers import Child, Interrupt, ModifierContext
from seoro.runtime.contracts.worlds import Simulation, Worlds
from seoro.runtime.functions.actions import action
from seoro.runtime.functions.modifiers import modifier
from seoro.runtime.values.values import Struct
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
        raise ActionFailed("unsupported `entity_namespace`: models have no ROS 2 topics here; omit it")
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
    """Set the pose and velocity of an entity."""
    parts = [part for part in acceleration.fields.values() if isinstance(part, Struct)]
    if any(value for part in parts for value in part.fields.values()):
        raise ActionFailed("unsupported `acceleration`: it cannot be set; omit it")
    await ctx.ask(ctx.anywhere(Simulation).set_entity_state(entity, pose, twist))


@action("reset_simulation", anywhere=Simulation)
async def reset_simulation(ctx: ActionContext) -> None:
    """Reset the world to its initial state; the time of the run goes on."""
    await ctx.ask(ctx.anywhere(Simulation).reset_simulation())


@action("load_world", anywhere=Worlds, uris=("uri",))
async def load_world(ctx: ActionContext, uri: str) -> None:
    """Continue in another world; the time of the run goes on."""
    await ctx.ask(ctx.anywhere(Worlds).change_world(uri))


@action("step_simulation", anywhere=Simulation)
async def step_simulation(ctx: ActionContext, steps: int) -> None:
    """Run physics steps while paused."""
    await ctx.ask(ctx.anywhere(Simulation).step_simulation(steps))


# ---------------------------------------------------------------- contacts


@modifier("allow_contact")
async def allow_contact(ctx: ModifierContext, child: Child, entities: Sequence[str]) -> Outcome:
    """Allow robots to touch entities within the behavior; all entities if empty."""
    with ctx.allow_contact(entities):
        outcome = await child.run()
    assert outcome is not None, "it has no limit"
    return outcome


@modifier("forbid_contact")
async def forbid_contact(
    ctx: ModifierContext, child: Child, robots: Sequence[str], allowed: Sequence[str], also_struck: bool
) -> Outcome:
    """Fail as soon as a robot strikes an entity that is not allowed."""
    found = Interrupt()
    try:
        with ctx.forbid_contact(robots, allowed, found, also_struck=also_struck):
            outcome = await child.run(interrupt=found)
    finally:
        if found.reason:
            ctx.record_margin(0.0, 0.0)
        elif not allowed:  # distances to allowed entities would count, too
            for robot, distance in await ctx.closest_approaches(robots):
                ctx.record_margin(distance, 0.0, robot)
    return Outcome(Status.FAILED, found.reason) if outcome is None else outcome
