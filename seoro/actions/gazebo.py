"""Actions of `osc.gazebo`: things in a simulated world, whichever simulator it is.

The names are those that scenario files for Gazebo use. `world_name` names a world of a server that has several;
here a run has one, and only the default is taken. Models that are macros (`xacro_arguments`) are not expanded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from seoro.errors import ActionFailed
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Simulation
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Pose3D
from seoro.runtime.values import Actor

DEFAULT_WORLD = "default"


@dataclass(frozen=True)
class SpawnEntity:
    """The struct `spawn_entity`: what to spawn, and where."""

    entity_name: str
    spawn_pose: Pose3D
    model: str
    xacro_arguments: str


@action("osc_actor.spawn", anywhere=Simulation, uris=("model",))
async def spawn(
    ctx: ActionContext, actor: Actor, spawn_pose: Pose3D, model: str, world_name: str, xacro_arguments: str
) -> None:
    """Spawn the actor's model."""
    _check(world_name, xacro_arguments)
    await ctx.ask(ctx.anywhere(Simulation).spawn_entity(_entity(actor), model, spawn_pose))


@action("osc_actor.relative_spawn", anywhere=Simulation, uris=("model",))
async def relative_spawn(
    ctx: ActionContext,
    actor: Actor,
    frame_id: str,
    parent_frame_id: str,
    distance: float,
    model: str,
    world_name: str,
    xacro_arguments: str,
) -> None:
    """Spawn the actor's model at a distance ahead of a frame."""
    _check(world_name, xacro_arguments)
    simulation = ctx.anywhere(Simulation)
    pose = await ctx.ask(simulation.relative_pose(frame_id, parent_frame_id, distance))
    await ctx.ask(simulation.spawn_entity(_entity(actor), model, pose))


@action("osc_actor.delete", anywhere=Simulation)
async def delete(ctx: ActionContext, actor: Actor, entity_name: str, world_name: str) -> None:
    """Delete an entity."""
    _check(world_name)
    await ctx.ask(ctx.anywhere(Simulation).delete_entity(entity_name))


@action("spawn_multiple", anywhere=Simulation)
async def spawn_multiple(ctx: ActionContext, entities: Sequence[SpawnEntity], world_name: str) -> None:
    """Spawn several entities, in their order."""
    for entity in entities:
        _check(world_name, entity.xacro_arguments)
    wanted = [(entity.entity_name, entity.model, entity.spawn_pose) for entity in entities]
    await ctx.ask(ctx.anywhere(Simulation).spawn_entities(wanted))


@action("actor_exists", anywhere=Simulation)
async def actor_exists(ctx: ActionContext, entity_name: str, world_name: str) -> None:
    """Check that an entity is there."""
    _check(world_name)
    names = await ctx.ask(ctx.anywhere(Simulation).entities())
    if entity_name not in names:
        raise ActionFailed(f"there is no entity '{entity_name}'; there are {', '.join(names)}")


@action("wait_for_sim", anywhere=Simulation)
async def wait_for_sim(ctx: ActionContext, timeout: float, world_name: str) -> None:
    """Wait for the simulator, which has been there since before the run began."""
    _check(world_name)
    await ctx.ask(ctx.anywhere(Simulation).entities())


def _check(world_name: str, xacro_arguments: str = "") -> None:
    if world_name != DEFAULT_WORLD:
        raise ActionFailed(f"there is one world here, called '{DEFAULT_WORLD}', not '{world_name}'")
    if xacro_arguments:
        raise ActionFailed("`xacro_arguments` are not supported: models are not expanded as macros")


def _entity(actor: Actor) -> str:
    """What an actor is called in the simulator."""
    return actor.name.replace(".", "_")
