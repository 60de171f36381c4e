"""Entities, filters and results as `simulation_interfaces` says them, and as simulator nodes do."""

from __future__ import annotations

from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.expose.messages import MAP
from seoro.bridges.wire import Result, SimulationState
from seoro.errors import BackendRefused

EMPTY, BOX = 0, 1  # kinds of `simulation_interfaces/Bounds`
STATES = {
    SimulationState.STOPPED: 0,
    SimulationState.PLAYING: 1,
    SimulationState.PAUSED: 2,
    SimulationState.NO_WORLD: 4,
}
INVALID_POSE = 101  # of `SetEntityState`
NO_WORLD_LOADED = 101  # of the services that ask for the world

Fields = dict[str, Any]


def done() -> Fields:
    """The `simulation_interfaces/Result` of what went well."""
    return {"result": int(Result.OK)}


def refused(code: int, message: str) -> Fields:
    """The `simulation_interfaces/Result` of what did not."""
    known = NO_WORLD_LOADED if code == wire.WorldResult.NO_WORLD_LOADED else code
    return {"result": int(known), "error_message": message}


def check_frame(frame: str, what: str, code: int) -> None:
    """Refuse frames that are not the world's.

    Raises:
        BackendRefused: It is another.
    """
    if frame not in ("", MAP, "world"):
        raise BackendRefused(f"{what} is in the frame {frame!r}: give it in {MAP!r}", code)


def entity_state(state: wire.EntityState, time: float) -> Fields:
    """A `simulation_interfaces/EntityState`; nothing is said of accelerations."""
    return {
        "header": geometry.header(MAP, time),
        "pose": geometry.pose_message(state.pose),
        "twist": geometry.twist_message(state.twist),
    }


def entity_info(info: wire.EntityInfo) -> Fields:
    """A `simulation_interfaces/EntityInfo`."""
    return {"category": {"category": info.category}, "description": info.description, "tags": list(info.tags)}


def entity_filter(filters: Any) -> wire.EntityFilter:
    """What `simulation_interfaces/EntityFilters` say.

    Raises:
        BackendRefused: Their bounds are of a kind that is not filtered by.
    """
    return wire.EntityFilter(
        filter=filters.filter,
        categories=tuple(int(category.category) for category in filters.categories),
        bounds=_box(filters.bounds),
        tags=tags_filter(filters.tags),
    )


def tags_filter(tags: Any) -> wire.TagsFilter:
    """What a `simulation_interfaces/TagsFilter` says."""
    return wire.TagsFilter(tags=tuple(tags.tags), filter_mode=int(tags.filter_mode))


def _box(bounds: Any) -> wire.Bounds | None:
    if bounds.type == EMPTY:
        return None
    if bounds.type != BOX or len(bounds.points) != 2:
        raise BackendRefused("bounds to filter by are a box of two points", Result.FEATURE_UNSUPPORTED)
    upper, lower = (geometry.vector(point) for point in bounds.points)
    return wire.Bounds(
        lower=wire.Vector3(x=min(lower.x, upper.x), y=min(lower.y, upper.y), z=min(lower.z, upper.z)),
        upper=wire.Vector3(x=max(lower.x, upper.x), y=max(lower.y, upper.y), z=max(lower.z, upper.z)),
    )


def bounds_message(bounds: wire.Bounds | None) -> Fields:
    """A `simulation_interfaces/Bounds`: a box by its upper and its lower corner, or nothing."""
    if bounds is None:
        return {"type": EMPTY}
    corners = [geometry.vector_message(bounds.upper), geometry.vector_message(bounds.lower)]
    return {"type": BOX, "points": corners}


def spawn_request(request: Any) -> wire.SpawnEntity:
    """What a request to spawn says (`SpawnEntity`, alone or among others).

    Raises:
        BackendRefused: It has a namespace, or a pose that is none here.
    """
    if request.entity_namespace:
        raise BackendRefused(
            "entities have no namespaces here: leave it empty", wire.SpawnResult.NAMESPACE_INVALID
        )
    stamped = request.initial_pose
    check_frame(stamped.header.frame_id, "the initial pose", wire.SpawnResult.INVALID_POSE)
    try:
        pose = geometry.pose(stamped.pose)
    except ValueError as error:
        raise BackendRefused(str(error), wire.SpawnResult.INVALID_POSE) from None
    return wire.SpawnEntity(
        name=request.name,
        uri=request.entity_resource.uri,
        resource_string=request.entity_resource.resource_string,
        initial_pose=pose,
        allow_renaming=bool(request.allow_renaming),
    )


def state_request(request: Any) -> wire.SetEntityState:
    """What a request `SetEntityState` says.

    Raises:
        BackendRefused: It sets an acceleration, or a pose that is none here.
    """
    if request.set_acceleration:
        raise BackendRefused("accelerations of entities cannot be set", Result.FEATURE_UNSUPPORTED)
    state = request.state
    check_frame(state.header.frame_id, "the state", Result.OPERATION_FAILED)
    try:
        pose = geometry.pose(state.pose) if request.set_pose else None
    except ValueError as error:
        raise BackendRefused(str(error), INVALID_POSE) from None
    return wire.SetEntityState(
        name=request.entity, pose=pose, twist=geometry.twist(state.twist) if request.set_twist else None
    )
