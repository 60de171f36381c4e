"""Verbs that query entities, worlds, poses, robots, models, frames and maps."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.wire import Category, Empty
from sim_nodes.known_entities import EntityInfo
from sim_nodes.listing import find_spawnables, find_worlds
from sim_nodes.messages import bounds_of, entity_state, flat_pose, pose_of
from sim_nodes.outcomes import operation_failed, unknown
from sim_nodes.robots.declaration import ArmDeclaration, LidarDeclaration
from sim_nodes.robots.postures import Posture
from sim_nodes.scenery import describe_map
from sim_nodes.sensors.description import describe_sensors
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.entities import check_categories, check_tags, check_tags_filter, filter_entities, has_tags
from sim_nodes.worlds.schema import MAX_DESCRIPTION


def get_entities_states(simulator: Simulator, request: wire.EntityFilter) -> wire.EntityStates:
    found = filter_entities(simulator.simulation.entities, request)
    return wire.EntityStates(names=tuple(found), states=tuple(map(entity_state, found.values())))


def get_entity_info(simulator: Simulator, request: wire.EntityName) -> wire.EntityInfo:
    info = simulator.simulation.entities.info(request.name)
    return wire.EntityInfo(category=info.category, description=info.description, tags=info.tags)


def set_entity_info(simulator: Simulator, request: wire.SetEntityInfo) -> None:
    info = request.info
    check_categories([info.category])
    check_tags(info.tags)
    if len(info.description) > MAX_DESCRIPTION:
        raise operation_failed(
            f"the description has {len(info.description)} characters; expected at most {MAX_DESCRIPTION}"
        )
    simulator.simulation.entities.set_info(
        request.name, EntityInfo(Category(info.category), info.description, info.tags)
    )


def get_entity_bounds(simulator: Simulator, request: wire.EntityName) -> wire.EntityBounds:
    box = simulator.simulation.entities.bounds(request.name)
    if box is None:
        return wire.EntityBounds(bounds=None)
    return wire.EntityBounds(bounds=bounds_of(box.lower.tolist(), box.upper.tolist()))


def get_named_poses(simulator: Simulator, request: wire.TagsFilter) -> wire.NamedPoses:
    check_tags_filter(request)
    return wire.NamedPoses(
        poses=tuple(
            wire.NamedPose(name=pose.name, description=pose.description, tags=pose.tags, pose=pose_of(pose.place))
            for pose in simulator.simulation.world.poses
            if has_tags(pose.tags, request)
        )
    )


def get_named_pose_bounds(simulator: Simulator, request: wire.PoseName) -> wire.NamedPoseBounds:
    poses = {pose.name: pose for pose in simulator.simulation.world.poses}
    if request.name not in poses:
        raise unknown(f"pose {request.name!r} of the world", "poses", poses)
    room = poses[request.name].room
    return wire.NamedPoseBounds(bounds=None if room is None else bounds_of(*room))


def get_current_world(simulator: Simulator, _: Empty) -> wire.CurrentWorld:
    world = simulator.simulation.world
    return wire.CurrentWorld(
        name=world.name, source=simulator.source, description=world.description, tags=world.tags
    )


def get_available_worlds(_: Simulator, request: wire.GetAvailableWorlds) -> wire.AvailableWorlds:
    check_tags_filter(request.tags)
    found, message = find_worlds(request.sources)
    worlds = tuple(world for world in found if has_tags(world.tags, request.tags))
    return wire.AvailableWorlds(names=tuple(world.source for world in worlds), worlds=worlds, message=message)


def get_simulation_state(simulator: Simulator, _: Empty) -> wire.CurrentState:
    return wire.CurrentState(state=simulator.state, time=simulator.time)


def get_transforms(simulator: Simulator, _: Empty) -> wire.Transforms:
    poses = {name: simulator.simulation.pose(name) for name in simulator.simulation.frames.names}
    return wire.Transforms(
        transforms=tuple(
            wire.Transform(frame=name, pose=None if pose is None else flat_pose(pose))
            for name, pose in poses.items()
        )
    )


def get_map(simulator: Simulator, _: Empty) -> wire.OccupancyGrid:
    return describe_map(simulator.simulation.shown_map)


def get_scene(simulator: Simulator, _: Empty) -> wire.Scene:
    return simulator.simulation.describe_scene()


def get_robot_description(simulator: Simulator, request: wire.RobotName) -> wire.RobotDescription:
    robot = simulator.simulation.robot(request.robot)
    declaration = robot.declaration
    mobile, arm = declaration.mobile, declaration.arm
    return wire.RobotDescription(
        urdf=declaration.source,
        base_link=declaration.base_link,
        sensors=tuple(robot.sensors),
        lidar=None if mobile is None or mobile.lidar is None else _lidar(mobile.lidar),
        arm=None if arm is None else _arm(arm, declaration.postures),
        max_speed=0.0 if mobile is None else mobile.drive.max_speed,
        max_turn_rate=0.0 if mobile is None else mobile.drive.max_turn_rate,
        has_battery=mobile is not None and mobile.battery is not None,
        mounted=tuple(describe_sensors(declaration)),
    )


def _lidar(lidar: LidarDeclaration) -> wire.LidarDescription:
    return wire.LidarDescription(
        link=lidar.link, yaw=lidar.yaw, range_min=lidar.min_range, range_max=lidar.max_range, rate=lidar.rate
    )


def _arm(arm: ArmDeclaration, postures: Sequence[Posture]) -> wire.ArmDescription:
    return wire.ArmDescription(
        joints=tuple(joint.name for joint in arm.joints),
        fingers=arm.fingers,
        stroke=0.0 if arm.gripper is None else arm.gripper.stroke,
        postures=tuple(posture.name for posture in postures),
    )


def get_spawnables(simulator: Simulator, request: wire.GetSpawnables) -> wire.Spawnables:
    found, message = find_spawnables(simulator.models, simulator.simulation.world, request.sources)
    return wire.Spawnables(spawnables=tuple(found), message=message)
