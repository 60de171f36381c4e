"""Actions of `osc.gazebo`: entities in a simulated world, in any simulator.

The names are those of scenario files for Gazebo. `world_name` selects a world of a server with several worlds; a
run has one world, so only the default is accepted. Macros in models (`xacro_arguments`) are not supported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.worlds import Simulation
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

DEFAULT_WORLD = "default"


@dataclass(frozen=True)
class SpawnEntity:
    """The struct `spawn_entity`: an entity and its pose."""

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
    """Check that an entity exists."""
    _check(world_name)
    names = await ctx.ask(ctx.anywhere(Simulation).entities())
    if entity_name not in names:
        raise ActionFailed(f"unknown entity '{entity_name}' (entities: {', '.join(names)})")


@action("wait_for_sim", anywhere=Simulation)
async def wait_for_sim(ctx: ActionContext, timeout: float, world_name: str) -> None:
    """Wait for the simulator. It is ready before the run starts."""
    _check(world_name)
    await ctx.ask(ctx.anywhere(Simulation).entities())


def _check(world_name: str, xacro_arguments: str = "") -> None:
    if world_name != DEFAULT_WORLD:
        raise ActionFailed(f"unknown world '{world_name}'; expected '{DEFAULT_WORLD}': a run has one world")
    if xacro_arguments:
        raise ActionFailed("`xacro_arguments` are not supported; expand the macros of the model beforehand")


def _entity(actor: Actor) -> str:
    """Return the name of an actor in the simulator."""
    return actor.name.replace(".", "_")
