"""Verbs about entities of the world."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.entities import SpawnRequest
from sim_nodes.messages import body_state, check_pose, entity_state
from sim_nodes.models import parse_model
from sim_nodes.physics import BodyModel
from sim_nodes.simulator import Simulator
from sim_nodes.spawnables import model_of
from sim_nodes.verbs.filters import check_tags, filter_entities

MAX_SPEED = 100.0  # [m/s], [rad/s]


def spawn_entity(simulator: Simulator, request: wire.SpawnEntity) -> wire.EntityName:
    simulation = simulator.simulation
    return wire.EntityName(name=simulation.entities.spawn(_spawn_request(simulator, request), simulation.time))


def spawn_entities(simulator: Simulator, request: wire.SpawnEntities) -> wire.SpawnOutcomes:
    wishes: list[SpawnRequest | RequestRefused] = []
    for each in request.entities:
        try:
            wishes.append(_spawn_request(simulator, each))
        except RequestRefused as refused:
            wishes.append(refused)
    possible = [spawn_request for spawn_request in wishes if isinstance(spawn_request, SpawnRequest)]
    spawned = iter(simulator.simulation.entities.spawn_all(possible, simulator.simulation.time))
    results = [
        next(spawned) if isinstance(spawn_request, SpawnRequest) else spawn_request for spawn_request in wishes
    ]
    return wire.SpawnOutcomes(
        results=tuple(
            wire.SpawnOutcome(name=result)
            if isinstance(result, str)
            else wire.SpawnOutcome(name=each.name, code=result.code, message=result.message)
            for each, result in zip(request.entities, results, strict=True)
        )
    )


def _spawn_request(simulator: Simulator, request: wire.SpawnEntity) -> SpawnRequest:
    """Convert a request to a `SpawnRequest`.

    Raises:
        RequestRefused: The pose, a tag or the model is invalid.
    """
    check_tags(request.tags)
    check_pose(request.initial_pose, wire.SpawnResult.INVALID_POSE)
    if not (request.uri or request.resource_string):
        raise RequestRefused(wire.SpawnResult.NO_RESOURCE, "missing model; expected its text or its URI")
    try:
        model = _model(simulator, request)
    except RequestRefused as error:
        raise RequestRefused(error.code, f"{request.uri}: {error.message}") from error
    return SpawnRequest(
        request.name, model, body_state(request.initial_pose), request.allow_renaming, request.tags
    )


def _model(simulator: Simulator, request: wire.SpawnEntity) -> BodyModel:
    if request.resource_string:
        if not request.resource_string.strip():
            raise RequestRefused(wire.SpawnResult.NO_RESOURCE, "the model is empty")
        return parse_model(request.resource_string)
    return model_of(request.uri, simulator.models, simulator.simulation.world)


def delete_entity(simulator: Simulator, request: wire.EntityName) -> None:
    simulator.simulation.entities.delete(request.name)


def get_entities(simulator: Simulator, request: wire.EntityFilter) -> wire.Entities:
    return wire.Entities(names=tuple(filter_entities(simulator.simulation.entities, request)))


def get_entity_state(simulator: Simulator, request: wire.EntityName) -> wire.EntityState:
    return entity_state(simulator.simulation.entities.state(request.name))


def set_entity_state(simulator: Simulator, request: wire.SetEntityState) -> None:
    entities = simulator.simulation.entities
    present = entity_state(entities.state(request.name))
    pose = request.pose or present.pose
    check_pose(pose, Result.OPERATION_FAILED)
    twist = request.twist or present.twist
    speeds = (*twist.linear.model_dump().values(), *twist.angular.model_dump().values())
    if not all(abs(speed) <= MAX_SPEED for speed in speeds):
        raise RequestRefused(
            Result.OPERATION_FAILED, f"invalid twist {speeds}; expected numbers up to {MAX_SPEED:g}"
        )
    simulator.simulation.move(request.name, body_state(pose, twist))
