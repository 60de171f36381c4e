"""Verbs that tell what there is."""

from __future__ import annotations

import numpy as np

from seoro.bridges import wire
from seoro.bridges.wire import Category, Empty, Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.entities import Info
from sim_nodes.messages import bounds_of, entity_state, flat_pose, pose_of
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.filters import check_categories, check_tags, check_tags_filter, chosen, has_tags
from sim_nodes.verbs.handling import Handling
from sim_nodes.worlds.listing import find_worlds
from sim_nodes.worlds.schema import MAX_DESCRIPTION

OCCUPIED = 100  # of a cell, by nav_msgs/OccupancyGrid


def _get_entities_states(simulator: Simulator, request: wire.EntityFilter) -> wire.EntityStates:
    found = chosen(simulator.simulation.entities, request)
    return wire.EntityStates(names=tuple(found), states=tuple(map(entity_state, found.values())))


def _get_entity_info(simulator: Simulator, request: wire.EntityName) -> wire.EntityInfo:
    info = simulator.simulation.entities.info(request.name)
    return wire.EntityInfo(category=info.category, description=info.description, tags=info.tags)


def _set_entity_info(simulator: Simulator, request: wire.SetEntityInfo) -> Empty:
    info = request.info
    check_categories([info.category])
    check_tags(info.tags)
    if len(info.description) > MAX_DESCRIPTION:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"a description has {MAX_DESCRIPTION} characters at most, not {len(info.description)}",
        )
    simulator.simulation.entities.tell(request.name, Info(Category(info.category), info.description, info.tags))
    return Empty()


def _get_entity_bounds(simulator: Simulator, request: wire.EntityName) -> wire.EntityBounds:
    box = simulator.simulation.entities.bounds(request.name)
    if box is None:
        return wire.EntityBounds(bounds=None)
    return wire.EntityBounds(bounds=bounds_of(box.lower.tolist(), box.upper.tolist()))


def _get_named_poses(simulator: Simulator, request: wire.TagsFilter) -> wire.NamedPoses:
    check_tags_filter(request)
    return wire.NamedPoses(
        poses=tuple(
            wire.NamedPose(name=pose.name, description=pose.description, tags=pose.tags, pose=pose_of(pose.place))
            for pose in simulator.simulation.world.poses
            if has_tags(pose.tags, request)
        )
    )


def _get_named_pose_bounds(simulator: Simulator, request: wire.PoseName) -> wire.NamedPoseBounds:
    poses = {pose.name: pose for pose in simulator.simulation.world.poses}
    if request.name not in poses:
        raise RequestRefused(
            Result.NOT_FOUND, f"the world has no pose {request.name!r}: named are {listed(poses)}"
        )
    room = poses[request.name].room
    return wire.NamedPoseBounds(bounds=None if room is None else bounds_of(*room))


def _get_current_world(simulator: Simulator, _: Empty) -> wire.CurrentWorld:
    world = simulator.simulation.world
    return wire.CurrentWorld(
        name=world.name, source=simulator.source, description=world.description, tags=world.tags
    )


def _get_available_worlds(_: Simulator, request: wire.GetAvailableWorlds) -> wire.AvailableWorlds:
    check_tags_filter(request.tags)
    found, message = find_worlds(request.sources)
    worlds = tuple(
        wire.WorldInfo(source=world.source, description=world.description, tags=world.tags)
        for world in found
        if has_tags(world.tags, request.tags)
    )
    return wire.AvailableWorlds(names=tuple(world.source for world in worlds), worlds=worlds, message=message)


def _get_simulation_state(simulator: Simulator, _: Empty) -> wire.CurrentState:
    return wire.CurrentState(state=simulator.state, time=simulator.time)


def _get_transforms(simulator: Simulator, _: Empty) -> wire.Transforms:
    poses = {name: simulator.simulation.pose(name) for name in simulator.simulation.frames.names}
    return wire.Transforms(
        transforms=tuple(
            wire.Transform(frame=name, pose=None if pose is None else flat_pose(pose))
            for name, pose in poses.items()
        )
    )


def _get_map(simulator: Simulator, _: Empty) -> wire.OccupancyGrid:
    known = simulator.simulation.known
    grid = known.grid
    occupied = np.where(known.distance <= grid.resolution / 2.0, OCCUPIED, 0).astype(np.uint8)
    return wire.OccupancyGrid(
        resolution=grid.resolution,
        x=grid.x,
        y=grid.y,
        columns=grid.columns,
        rows=grid.rows,
        cells=occupied.T.tobytes(),
    )


HANDLERS: tuple[Handling, ...] = (
    (wire.GET_ENTITIES_STATES, _get_entities_states),
    (wire.GET_MAP, _get_map),
    (wire.GET_ENTITY_INFO, _get_entity_info),
    (wire.SET_ENTITY_INFO, _set_entity_info),
    (wire.GET_ENTITY_BOUNDS, _get_entity_bounds),
    (wire.GET_NAMED_POSES, _get_named_poses),
    (wire.GET_NAMED_POSE_BOUNDS, _get_named_pose_bounds),
    (wire.GET_CURRENT_WORLD, _get_current_world),
    (wire.GET_AVAILABLE_WORLDS, _get_available_worlds),
    (wire.GET_SIMULATION_STATE, _get_simulation_state),
    (wire.GET_TRANSFORMS, _get_transforms),
)
