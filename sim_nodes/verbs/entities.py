"""Verbs about what is in the world."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.entities import Wish
from sim_nodes.messages import body_state, check_pose, entity_state
from sim_nodes.models import parse_model
from sim_nodes.physics import BodyModel
from sim_nodes.simulator import Simulator
from sim_nodes.spawnables import model_of
from sim_nodes.verbs.filters import check_tags, chosen
from sim_nodes.verbs.handling import Handling

MAX_SPEED = 100.0  # [m/s], [rad/s]


def _spawn_entity(simulator: Simulator, request: wire.SpawnEntity) -> wire.EntityName:
    simulation = simulator.simulation
    return wire.EntityName(name=simulation.entities.spawn(_wish(simulator, request), simulation.time))


def _spawn_entities(simulator: Simulator, request: wire.SpawnEntities) -> wire.Spawnings:
    wishes: list[Wish | RequestRefused] = []
    for each in request.entities:
        try:
            wishes.append(_wish(simulator, each))
        except RequestRefused as refused:
            wishes.append(refused)
    possible = [wish for wish in wishes if isinstance(wish, Wish)]
    spawned = iter(simulator.simulation.entities.spawn_all(possible, simulator.simulation.time))
    results = [next(spawned) if isinstance(wish, Wish) else wish for wish in wishes]
    return wire.Spawnings(
        results=tuple(
            wire.Spawning(name=result)
            if isinstance(result, str)
            else wire.Spawning(name=each.name, code=result.code, message=result.message)
            for each, result in zip(request.entities, results, strict=True)
        )
    )


def _wish(simulator: Simulator, request: wire.SpawnEntity) -> Wish:
    """What is to be spawned.

    Raises:
        RequestRefused: The place or a tag is none, or the model is wrong.
    """
    check_tags(request.tags)
    check_pose(request.initial_pose, wire.SpawnResult.INVALID_POSE)
    if not (request.uri or request.resource_string):
        raise RequestRefused(wire.SpawnResult.NO_RESOURCE, "neither a model nor the URI of one was given")
    try:
        model = _model(simulator, request)
    except RequestRefused as error:
        raise RequestRefused(error.code, f"{request.uri}: {error.message}") from error
    return Wish(request.name, model, body_state(request.initial_pose), request.allow_renaming, request.tags)


def _model(simulator: Simulator, request: wire.SpawnEntity) -> BodyModel:
    if request.resource_string:
        if not request.resource_string.strip():
            raise RequestRefused(wire.SpawnResult.NO_RESOURCE, "the model is empty")
        return parse_model(request.resource_string)
    return model_of(request.uri, simulator.models, simulator.simulation.world)


def _delete_entity(simulator: Simulator, request: wire.EntityName) -> Empty:
    simulator.simulation.entities.delete(request.name)
    return Empty()


def _get_entities(simulator: Simulator, request: wire.EntityFilter) -> wire.Entities:
    return wire.Entities(names=tuple(chosen(simulator.simulation.entities, request)))


def _get_entity_state(simulator: Simulator, request: wire.EntityName) -> wire.EntityState:
    return entity_state(simulator.simulation.entities.state(request.name))


def _set_entity_state(simulator: Simulator, request: wire.SetEntityState) -> Empty:
    entities = simulator.simulation.entities
    present = entity_state(entities.state(request.name))
    pose = request.pose or present.pose
    check_pose(pose, Result.OPERATION_FAILED)
    twist = request.twist or present.twist
    speeds = (*twist.linear.model_dump().values(), *twist.angular.model_dump().values())
    if not all(abs(speed) <= MAX_SPEED for speed in speeds):
        raise RequestRefused(
            Result.OPERATION_FAILED, f"the twist {speeds} has a part that is no number up to {MAX_SPEED:g}"
        )
    simulator.simulation.move(request.name, body_state(pose, twist))
    return Empty()


HANDLERS: tuple[Handling, ...] = (
    (wire.SPAWN_ENTITY, _spawn_entity),
    (wire.SPAWN_ENTITIES, _spawn_entities),
    (wire.DELETE_ENTITY, _delete_entity),
    (wire.GET_ENTITIES, _get_entities),
    (wire.GET_ENTITY_STATE, _get_entity_state),
    (wire.SET_ENTITY_STATE, _set_entity_state),
)
