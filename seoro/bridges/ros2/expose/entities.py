"""Conversion of requests, replies and results between `simulation_interfaces` and simulator nodes."""

from __future__ import annotations

from collections.abc import Sequence
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
INVALID_POSE = 101  # result of `SetEntityState`
NO_WORLD_LOADED = 101  # result of services about the world

Fields = dict[str, Any]


def succeeded(message: str = "") -> Fields:
    """Make the `simulation_interfaces/Result` of a success, with an optional warning."""
    return {"result": int(Result.OK), "error_message": message}


def refused(code: int, message: str) -> Fields:
    """Make the `simulation_interfaces/Result` of a failure."""
    known = NO_WORLD_LOADED if code == wire.WorldResult.NO_WORLD_LOADED else code
    return {"result": int(known), "error_message": message}


def check_frame(frame: str, what: str, code: int) -> None:
    """Check that a pose is in the frame of the world.

    Raises:
        BackendRefused: The pose is in another frame.
    """
    if frame not in ("", MAP, "world"):
        raise BackendRefused(f"unsupported frame {frame!r} of {what}: expected {MAP!r}", code)


def read_pose(message: Any, code: int) -> wire.Pose3D:
    """Convert a `geometry_msgs/Pose`.

    Raises:
        BackendRefused: The pose is invalid.
    """
    try:
        return geometry.pose(message)
    except ValueError as error:
        raise BackendRefused(str(error), code) from None


def entity_name(request: Any) -> wire.EntityName:
    """Convert a request with the name of an entity."""
    return wire.EntityName(name=request.entity)


def entity_state(state: wire.EntityState, time: float) -> Fields:
    """Make a `simulation_interfaces/EntityState`; accelerations stay zero."""
    return {
        "header": geometry.header(MAP, time),
        "pose": geometry.pose_message(state.pose),
        "twist": geometry.twist_message(state.twist),
    }


def entity_info(info: wire.EntityInfo) -> Fields:
    """Make a `simulation_interfaces/EntityInfo`."""
    return {"category": {"category": info.category}, "description": info.description, "tags": list(info.tags)}


def info_request(request: Any) -> wire.SetEntityInfo:
    """Convert a `SetEntityInfo` request."""
    info = wire.EntityInfo(
        category=int(request.info.category.category),
        description=request.info.description,
        tags=tuple(request.info.tags),
    )
    return wire.SetEntityInfo(name=request.entity, info=info)


def entity_filter(request: Any) -> wire.EntityFilter:
    """Convert the filters of a request.

    Raises:
        BackendRefused: The kind of the bounds is unsupported.
    """
    filters = request.filters
    return wire.EntityFilter(
        filter=filters.filter,
        categories=tuple(int(category.category) for category in filters.categories),
        bounds=_box(filters.bounds),
        tags=tags_filter(filters.tags),
    )


def tags_filter(tags: Any) -> wire.TagsFilter:
    """Convert a `simulation_interfaces/TagsFilter`."""
    return wire.TagsFilter(tags=tuple(tags.tags), filter_mode=int(tags.filter_mode))


def _box(bounds: Any) -> wire.Bounds | None:
    if bounds.type == EMPTY:
        return None
    if bounds.type != BOX or len(bounds.points) != 2:
        raise BackendRefused(
            "unsupported bounds of a filter: expected a box of two points", Result.FEATURE_UNSUPPORTED
        )
    upper, lower = (geometry.vector(point) for point in bounds.points)
    return wire.Bounds(
        lower=wire.Position3D(x=min(lower.x, upper.x), y=min(lower.y, upper.y), z=min(lower.z, upper.z)),
        upper=wire.Position3D(x=max(lower.x, upper.x), y=max(lower.y, upper.y), z=max(lower.z, upper.z)),
    )


def bounds_message(bounds: wire.Bounds | None) -> Fields:
    """Make a `simulation_interfaces/Bounds`: a box with its upper and lower corner, or empty."""
    if bounds is None:
        return {"type": EMPTY}
    corners = [geometry.vector_message(bounds.upper), geometry.vector_message(bounds.lower)]
    return {"type": BOX, "points": corners}


def bounds_fields(reply: Any) -> Fields:
    """Return the members of a response with bounds."""
    return {"bounds": bounds_message(reply.bounds)}


def named_poses(reply: wire.NamedPoses) -> Fields:
    """Return the members of a `GetNamedPoses` response."""
    poses = [
        {
            "name": each.name,
            "description": each.description,
            "tags": list(each.tags),
            "pose": geometry.pose_message(each.pose),
        }
        for each in reply.poses
    ]
    return {"poses": poses}


def spawnables(reply: wire.Spawnables) -> Fields:
    """Return the members of a `GetSpawnables` response."""
    found = [
        {
            "entity_resource": {"uri": each.uri},
            "description": each.description,
            "spawn_bounds": bounds_message(each.bounds),
        }
        for each in reply.spawnables
    ]
    return {"result": succeeded(reply.message), "spawnables": found}


def simulation_state_request(request: Any) -> wire.SetSimulationState:
    """Convert a `SetSimulationState` request.

    Raises:
        BackendRefused: The state cannot be set.
    """
    wanted = next((state for state, number in STATES.items() if number == request.state.state), None)
    if wanted is None:
        raise BackendRefused(
            f"unsupported state {request.state.state}: expected 0 (stopped), 1 (playing) or 2 (paused)",
            Result.FEATURE_UNSUPPORTED,
        )
    return wire.SetSimulationState(state=wanted)


def world_resource(name: str, uri: str, description: str = "", tags: Sequence[str] = ()) -> Fields:
    """Make a `simulation_interfaces/WorldResource`."""
    return {"name": name, "world_resource": {"uri": uri}, "description": description, "tags": list(tags)}


def current_world(world: wire.CurrentWorld) -> Fields:
    """Return the members of a `GetCurrentWorld` response."""
    return {"world": world_resource(world.name, world.source, world.description, world.tags)}


def worlds_request(request: Any) -> wire.GetAvailableWorlds:
    """Convert a `GetAvailableWorlds` request."""
    return wire.GetAvailableWorlds(tags=tags_filter(request.filter), sources=tuple(request.additional_sources))


def available_worlds(reply: wire.AvailableWorlds) -> Fields:
    """Return the members of a `GetAvailableWorlds` response."""
    worlds = [world_resource(each.source, each.source, each.description, each.tags) for each in reply.worlds]
    return {"result": succeeded(reply.message), "worlds": worlds}


def spawn_request(request: Any) -> wire.SpawnEntity:
    """Convert a spawn request (`SpawnEntity`, alone or among others).

    Raises:
        BackendRefused: The request has a namespace, or an invalid pose.
    """
    if request.entity_namespace:
        raise BackendRefused(
            "namespaces of entities are unsupported: leave it empty", wire.SpawnResult.NAMESPACE_INVALID
        )
    stamped = request.initial_pose
    check_frame(stamped.header.frame_id, "the initial pose", wire.SpawnResult.INVALID_POSE)
    return wire.SpawnEntity(
        name=request.name,
        uri=request.entity_resource.uri,
        resource_string=request.entity_resource.resource_string,
        initial_pose=read_pose(stamped.pose, wire.SpawnResult.INVALID_POSE),
        allow_renaming=bool(request.allow_renaming),
    )


def state_request(request: Any) -> wire.SetEntityState:
    """Convert a `SetEntityState` request.

    Raises:
        BackendRefused: The request sets an acceleration, or has an invalid pose.
    """
    if request.set_acceleration:
        raise BackendRefused("accelerations of entities cannot be set", Result.FEATURE_UNSUPPORTED)
    state = request.state
    check_frame(state.header.frame_id, "the state", Result.OPERATION_FAILED)
    return wire.SetEntityState(
        name=request.entity,
        pose=read_pose(state.pose, INVALID_POSE) if request.set_pose else None,
        twist=geometry.twist(state.twist) if request.set_twist else None,
    )
