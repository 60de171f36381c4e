"""Verbs about cameras."""

from __future__ import annotations

import math

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.cameras import png
from sim_nodes.geometry import Vector
from sim_nodes.messages import FARTHEST, body_state, check_pose
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling
from sim_nodes.views import MAX_FOV, MAX_SIZE, MIN_FOV, MIN_SIZE, Lens


def _spawn_camera(simulator: Simulator, request: wire.SpawnCamera) -> wire.EntityName:
    check_pose(request.pose, wire.SpawnResult.INVALID_POSE)
    lens = _lens(request.fov, request.width, request.height)
    entities = simulator.simulation.entities
    return wire.EntityName(name=entities.spawn_camera(request.name, lens, body_state(request.pose)))


def _lens(fov: float, width: int, height: int) -> Lens:
    if not MIN_FOV <= fov <= MAX_FOV:
        low, high = (round(math.degrees(limit)) for limit in (MIN_FOV, MAX_FOV))
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"a field of view is {low} to {high} degrees, not {math.degrees(fov):g}",
        )
    if not all(MIN_SIZE <= size <= MAX_SIZE for size in (width, height)):
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"a picture has {MIN_SIZE} to {MAX_SIZE} pixels in each direction, not {width} by {height}",
        )
    return Lens(fov, width, height)


def _aim_camera(simulator: Simulator, request: wire.AimCamera) -> Empty:
    simulator.simulation.entities.cameras.aim(request.name, _point("target", request.target))
    return Empty()


def _follow_entity(simulator: Simulator, request: wire.FollowEntity) -> Empty:
    simulator.simulation.entities.follow(request.name, request.entity, _point("offset", request.offset))
    return Empty()


def _point(what: str, vector: wire.Vector3) -> Vector:
    values = (vector.x, vector.y, vector.z)
    if not all(math.isfinite(value) and abs(value) <= FARTHEST for value in values):
        raise RequestRefused(Result.OPERATION_FAILED, f"the {what} {values} is no place within {FARTHEST:.0f} m")
    return values


def _get_cameras(simulator: Simulator, _: Empty) -> wire.CameraNames:
    return wire.CameraNames(names=simulator.simulation.entities.cameras.names())


def _get_camera_image(simulator: Simulator, request: wire.EntityName) -> wire.CameraImage:
    simulation = simulator.simulation
    given = simulation.entities.cameras.picture(request.name, simulation.tick)
    is_of_now = given.tick == simulation.tick
    height, width, _ = given.picture.shape
    return wire.CameraImage(
        time=simulation.time if is_of_now else simulation.time_of_tick(given.tick),
        width=width,
        height=height,
        data=png(given.picture),
    )


HANDLERS: tuple[Handling, ...] = (
    (wire.SPAWN_CAMERA, _spawn_camera),
    (wire.AIM_CAMERA, _aim_camera),
    (wire.FOLLOW_ENTITY, _follow_entity),
    (wire.GET_CAMERAS, _get_cameras),
    (wire.GET_CAMERA_IMAGE, _get_camera_image),
)
