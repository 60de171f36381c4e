"""Actions of `osc.gazebo`: entities in a simulated world, in any simulator.

The names are those of scenario files for Gazebo. `world_name` selects a world of a server with several worlds; a
run has one world, so only the default is accepted. `xacro_arguments` are pairs `key:=value` between commas.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlencode

from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.worlds import Simulation
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

DEFAULT_WORLD = "default"
XACRO = ".xacro"


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
    _check(world_name)
    uri = _with_arguments(model, xacro_arguments)
    await ctx.ask(ctx.anywhere(Simulation).spawn_entity(_entity(actor), uri, spawn_pose))


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
    _check(world_name)
    uri = _with_arguments(model, xacro_arguments)
    simulation = ctx.anywhere(Simulation)
    pose = await ctx.ask(simulation.relative_pose(frame_id, parent_frame_id, distance))
    await ctx.ask(simulation.spawn_entity(_entity(actor), uri, pose))


@action("osc_actor.delete", anywhere=Simulation)
async def delete(ctx: ActionContext, actor: Actor, entity_name: str, world_name: str) -> None:
    """Delete an entity."""
    _check(world_name)
    await ctx.ask(ctx.anywhere(Simulation).delete_entity(entity_name))


@action("spawn_multiple", anywhere=Simulation)
async def spawn_multiple(ctx: ActionContext, entities: Sequence[SpawnEntity], world_name: str) -> None:
    """Spawn several entities, in their order."""
    _check(world_name)
    wanted = [
        (entity.entity_name, _with_arguments(entity.model, entity.xacro_arguments), entity.spawn_pose)
        for entity in entities
    ]
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


def _check(world_name: str) -> None:
    if world_name != DEFAULT_WORLD:
        raise ActionFailed(f"unknown world '{world_name}'; expected '{DEFAULT_WORLD}': a run has one world")


def _with_arguments(model: str, arguments: str) -> str:
    """Return the URI of a model with arguments of xacro.

    Args:
        model: URI of the model.
        arguments: Pairs `key:=value` between commas, or nothing.

    Raises:
        ActionFailed: The arguments are invalid, or the model is not a xacro file.
    """
    if not arguments.strip():
        return model
    if not model.endswith(XACRO):
        raise ActionFailed(f"unexpected `xacro_arguments` for '{model}'; expected a model in a {XACRO} file")
    pairs = [pair.strip().partition(":=") for pair in arguments.split(",")]
    wrong = next((key for key, separator, _ in pairs if not key or not separator), None)
    if wrong is not None:
        raise ActionFailed(f"invalid `xacro_arguments` '{arguments}'; expected `key:=value`, with commas between")
    return f"{model}?{urlencode([(key.strip(), value.strip()) for key, _, value in pairs])}"


def _entity(actor: Actor) -> str:
    """Return the name of an actor in the simulator."""
    return actor.name.replace(".", "_")
