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
from sim_nodes.views import MAX_FOV, MAX_SIZE, MIN_FOV, MIN_SIZE, Lens


def spawn_camera(simulator: Simulator, request: wire.SpawnCamera) -> wire.EntityName:
    check_pose(request.pose, wire.SpawnResult.INVALID_POSE)
    lens = _lens(request.fov, request.width, request.height)
    entities = simulator.simulation.entities
    return wire.EntityName(name=entities.spawn_camera(request.name, lens, body_state(request.pose)))


def _lens(fov: float, width: int, height: int) -> Lens:
    if not MIN_FOV <= fov <= MAX_FOV:
        low, high = (round(math.degrees(limit)) for limit in (MIN_FOV, MAX_FOV))
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid field of view {math.degrees(fov):g} degrees; expected {low} to {high} degrees",
        )
    if not all(MIN_SIZE <= size <= MAX_SIZE for size in (width, height)):
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid image size {width} by {height}; expected {MIN_SIZE} to {MAX_SIZE} pixels",
        )
    return Lens(fov, width, height)


def aim_camera(simulator: Simulator, request: wire.AimCamera) -> None:
    simulator.simulation.entities.cameras.aim(request.name, _point("target", request.target))


def follow_entity(simulator: Simulator, request: wire.FollowEntity) -> None:
    simulator.simulation.entities.follow(request.name, request.entity, _point("offset", request.offset))


def _point(what: str, vector: wire.Position3D) -> Vector:
    values = (vector.x, vector.y, vector.z)
    if not all(math.isfinite(value) and abs(value) <= FARTHEST for value in values):
        raise RequestRefused(Result.OPERATION_FAILED, f"invalid {what} {values}; expected up to {FARTHEST:.0f} m")
    return values


def get_cameras(simulator: Simulator, _: Empty) -> wire.CameraNames:
    return wire.CameraNames(names=simulator.simulation.entities.cameras.names())


def get_camera_image(simulator: Simulator, request: wire.EntityName) -> wire.CameraImage:
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
