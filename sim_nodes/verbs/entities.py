"""Verbs about entities of the world, and filters of entities and named poses."""

from __future__ import annotations

import re
from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.wire import Category, FilterMode, Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, name_list
from sim_nodes.entities import Entities
from sim_nodes.listing import bodies_of
from sim_nodes.messages import body_state, check_pose, entity_state
from sim_nodes.models import parse_bodies
from sim_nodes.models.scenes import SceneBody
from sim_nodes.outcomes import operation_failed
from sim_nodes.physics import BodyState
from sim_nodes.simulator import Simulator
from sim_nodes.spawning import SpawnRequest
from sim_nodes.worlds.fields import MAX_TAGS, TAG


def filter_entities(entities: Entities, request: wire.EntityFilter) -> dict[str, BodyState]:
    """Return the states of the entities that pass a filter, by name, sorted.

    Raises:
        RequestRefused: The filter is invalid.
    """
    check_categories(request.categories)
    check_tags_filter(request.tags)
    if request.bounds is not None:
        low, high = request.bounds.lower, request.bounds.upper
        check_finite("bounds", low.x, low.y, low.z, high.x, high.y, high.z)
    return {
        name: state
        for name in entities.matching(request.filter)
        for info, state in [(entities.info(name), entities.state(name))]
        if not request.categories or info.category in request.categories
        if has_tags(info.tags, request.tags)
        if request.bounds is None or _is_in(request.bounds, state)
    }


def has_tags(tags: Sequence[str], wanted: wire.TagsFilter) -> bool:
    """Whether an object with some tags passes a filter."""
    if not wanted.tags:
        return True
    found = (tag in tags for tag in wanted.tags)
    return all(found) if wanted.filter_mode == FilterMode.ALL else any(found)


def _is_in(bounds: wire.Bounds, state: BodyState) -> bool:
    low, high = bounds.lower, bounds.upper
    x, y, z = state.position
    return low.x <= x <= high.x and low.y <= y <= high.y and low.z <= z <= high.z


def check_categories(categories: Sequence[int]) -> None:
    """Refuse unknown categories."""
    unknown = [number for number in categories if number not in list(Category)]
    if unknown:
        known = ", ".join(f"{each.value} ({each.name.lower()})" for each in Category)
        raise operation_failed(f"unknown category {unknown[0]}; categories: {known}")


def check_tags(tags: Sequence[str]) -> None:
    """Refuse invalid tags."""
    if len(tags) > MAX_TAGS:
        raise operation_failed(f"found {len(tags)} tags; expected at most {MAX_TAGS}")
    wrong = [tag for tag in tags if not re.fullmatch(TAG, tag)]
    if wrong:
        raise operation_failed(f"invalid tag {wrong[0]!r}; expected 1 to 64 characters without spaces and commas")


def check_tags_filter(wanted: wire.TagsFilter) -> None:
    """Refuse filters with an invalid tag or an unknown mode."""
    check_tags(wanted.tags)
    if wanted.filter_mode not in list(FilterMode):
        raise operation_failed(
            f"unknown filter mode {wanted.filter_mode}; expected 0 (any of the tags) or 1 (all of them)"
        )


MAX_SPEED = 100.0  # [m/s], [rad/s]


def spawn_entity(simulator: Simulator, request: wire.SpawnEntity) -> wire.Spawned:
    simulation, wish = simulator.simulation, _spawn_request(simulator, request)
    name = simulation.entities.spawn(wish, simulation.time)
    return wire.Spawned(name=name, warnings=_warnings(simulator, name, wish))


def _warnings(simulator: Simulator, name: str, wish: SpawnRequest) -> tuple[str, ...]:
    """Return warnings about a spawned file: parts without effect, and the entities of further bodies."""
    others = simulator.simulation.entities.scene_of(name)[1:]
    return (*wish.notes, *((f"spawned with it: {name_list(others)}",) if others else ()))


def spawn_entities(simulator: Simulator, request: wire.SpawnEntities) -> wire.SpawnOutcomes:
    wishes: list[SpawnRequest | RequestRefused] = []
    for each in request.entities:
        try:
            wishes.append(_spawn_request(simulator, each))
        except RequestRefused as refused:
            wishes.append(refused)
    possible = [wish for wish in wishes if isinstance(wish, SpawnRequest)]
    spawned = iter(simulator.simulation.entities.spawn_all(possible, simulator.simulation.time))
    outcomes = []
    for wish, each in zip(wishes, request.entities, strict=True):
        result = next(spawned) if isinstance(wish, SpawnRequest) else wish
        if isinstance(wish, SpawnRequest) and isinstance(result, str):
            outcomes.append(wire.SpawnOutcome(name=result, warnings=_warnings(simulator, result, wish)))
        else:
            assert isinstance(result, RequestRefused)
            outcomes.append(wire.SpawnOutcome(name=each.name, code=result.code, message=result.message))
    return wire.SpawnOutcomes(results=tuple(outcomes))


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
        bodies = _bodies(simulator, request)
    except RequestRefused as error:
        raise RequestRefused(error.code, f"{request.uri}: {error.message}") from error
    return SpawnRequest(
        request.name, bodies, body_state(request.initial_pose), request.allow_renaming, request.tags
    )


def _bodies(simulator: Simulator, request: wire.SpawnEntity) -> tuple[SceneBody, ...]:
    if request.resource_string:
        if not request.resource_string.strip():
            raise RequestRefused(wire.SpawnResult.NO_RESOURCE, "the model is empty")
        return parse_bodies(request.resource_string, {file.path: file.data for file in request.files})
    return bodies_of(request.uri, simulator.models, simulator.simulation.world)


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
        raise operation_failed(f"invalid twist {speeds}; expected numbers up to {MAX_SPEED:g}")
    simulator.simulation.move(request.name, body_state(pose, twist))
