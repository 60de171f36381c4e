"""Verbs about sensors of robots, and about cameras."""

from __future__ import annotations

import math

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_positive
from sim_nodes.cameras import png
from sim_nodes.geometry import Vector
from sim_nodes.messages import FARTHEST, body_state, check_pose, sample_message
from sim_nodes.outcomes import incorrect_state, operation_failed
from sim_nodes.sensor_watches import BumperWatch, ForceWatch, RangeWatch, RateWatch, SampleWatch, SightWatch
from sim_nodes.sensors.base import Bumper
from sim_nodes.sensors.imaging import Segmentation
from sim_nodes.sensors.load import ForceTorque
from sim_nodes.simulator import Simulator
from sim_nodes.ticks import TICK
from sim_nodes.views import MAX_FOV, MAX_SIZE, MIN_FOV, MIN_SIZE, Lens

BUMPER = "bumper"
LONGEST = 3600.0  # [s] maximum period for counting samples


def get_sensor_sample(simulator: Simulator, request: wire.SensorName) -> wire.SensorSample:
    simulation = simulator.simulation
    pipeline = simulation.pipeline(request.robot, request.sensor)
    pipeline.activate()
    if pipeline.latest is None:
        raise incorrect_state(f"no sample of {request.robot}/{request.sensor} has arrived yet; let time pass")
    return sample_message(pipeline.latest, simulation.time_of_tick)


def watch_sensor(simulator: Simulator, request: wire.WatchSensor) -> None:
    simulator.simulation.pipeline(request.robot, request.sensor).activate()
    simulator.simulation.watch(request.id, SampleWatch(request.robot, request.sensor, simulator.simulation.tick))


def watch_bumper(simulator: Simulator, request: wire.WatchBumper) -> None:
    pipeline = simulator.simulation.pipeline(request.robot, BUMPER)
    assert isinstance(pipeline.sensor, Bumper)
    zones = pipeline.sensor.zones
    if request.zone and request.zone not in zones:
        raise RequestRefused(
            Result.NOT_FOUND,
            f"unknown zone {request.zone!r} of the bumper of {request.robot}; zones: {', '.join(zones)}",
        )
    pipeline.activate()
    simulator.simulation.watch(request.id, BumperWatch(request.robot, BUMPER, request.zone, request.entity))


def watch_range(simulator: Simulator, request: wire.WatchRange) -> None:
    check_positive("distance", request.distance, "m")
    check_finite("bearings", request.start, request.end)
    pipeline = simulator.simulation.pipeline(request.robot, request.sensor)
    if len(pipeline.sensor.bearings) == 0:
        raise operation_failed(f"{request.robot}/{request.sensor} does not measure ranges: it has no beams")
    pipeline.activate()
    watch = RangeWatch(request.robot, request.sensor, request.distance, request.start, request.end)
    simulator.simulation.watch(request.id, watch)


def watch_force(simulator: Simulator, request: wire.WatchForce) -> None:
    check_positive("force", request.force, "N")
    pipeline = simulator.simulation.pipeline(request.robot, request.sensor)
    if not isinstance(pipeline.sensor, ForceTorque):
        raise operation_failed(f"{request.robot}/{request.sensor} is not a force-torque sensor")
    pipeline.activate()
    simulator.simulation.watch(request.id, ForceWatch(request.robot, request.sensor, request.force))


def watch_sight(simulator: Simulator, request: wire.WatchSight) -> None:
    if not 0.0 <= request.share <= 1.0:
        raise operation_failed(f"invalid share {request.share:g} of a picture; expected 0 to 1")
    pipeline = simulator.simulation.pipeline(request.robot, request.sensor)
    if not isinstance(pipeline.sensor, Segmentation):
        raise operation_failed(f"{request.robot}/{request.sensor} is not a segmentation sensor")
    pipeline.activate()
    watch = SightWatch(request.robot, request.sensor, request.entity, request.share)
    simulator.simulation.watch(request.id, watch)


def check_rate(simulator: Simulator, request: wire.CheckRate) -> None:
    simulation = simulator.simulation
    if not TICK <= request.duration <= LONGEST:
        raise operation_failed(
            f"invalid duration {request.duration:g} s for counting samples; expected {TICK:g} to {LONGEST:g} s"
        )
    if not 0.0 <= request.lowest <= request.highest:
        raise operation_failed(
            f"invalid rate of {request.lowest:g} to {request.highest:g} samples per second; "
            "expected bounds of zero or more, the lower one first"
        )
    pipeline = simulation.pipeline(request.robot, request.sensor)
    pipeline.activate()
    end = simulation.tick + max(1, math.floor(request.duration / TICK + 0.5))
    watch = RateWatch(
        request.robot, request.sensor, pipeline.count, simulation.tick, end, request.lowest, request.highest
    )
    simulation.watch(request.id, watch)


def spawn_camera(simulator: Simulator, request: wire.SpawnCamera) -> wire.EntityName:
    check_pose(request.pose, wire.SpawnResult.INVALID_POSE)
    lens = _lens(request.fov, request.width, request.height)
    entities = simulator.simulation.entities
    return wire.EntityName(name=entities.spawn_camera(request.name, lens, body_state(request.pose)))


def _lens(fov: float, width: int, height: int) -> Lens:
    if not MIN_FOV <= fov <= MAX_FOV:
        low, high = (round(math.degrees(limit)) for limit in (MIN_FOV, MAX_FOV))
        raise operation_failed(
            f"invalid field of view {math.degrees(fov):g} degrees; expected {low} to {high} degrees"
        )
    if not all(MIN_SIZE <= size <= MAX_SIZE for size in (width, height)):
        raise operation_failed(f"invalid image size {width} by {height}; expected {MIN_SIZE} to {MAX_SIZE} pixels")
    return Lens(fov, width, height)


def aim_camera(simulator: Simulator, request: wire.AimCamera) -> None:
    simulator.simulation.entities.cameras.aim(request.name, _point("target", request.target))


def follow_entity(simulator: Simulator, request: wire.FollowEntity) -> None:
    simulator.simulation.entities.follow(request.name, request.entity, _point("offset", request.offset))


def _point(what: str, vector: wire.Position3D) -> Vector:
    values = (vector.x, vector.y, vector.z)
    if not all(math.isfinite(value) and abs(value) <= FARTHEST for value in values):
        raise operation_failed(f"invalid {what} {values}; expected up to {FARTHEST:.0f} m")
    return values


def get_cameras(simulator: Simulator, _: Empty) -> wire.CameraNames:
    return wire.CameraNames(names=simulator.simulation.entities.cameras.names())


def get_camera_image(simulator: Simulator, request: wire.EntityName) -> wire.CameraImage:
    simulation = simulator.simulation
    given = simulation.entities.cameras.picture(request.name, simulation.tick)
    is_of_now = given.tick == simulation.tick
    height, width, _ = given.data.shape
    return wire.CameraImage(
        time=simulation.time if is_of_now else simulation.time_of_tick(given.tick),
        width=width,
        height=height,
        data=png(given.data),
    )
