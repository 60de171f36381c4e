"""Verbs about sensors of robots."""

from __future__ import annotations

import math

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_positive
from sim_nodes.messages import sample_message
from sim_nodes.sensors.bumper import Bumper
from sim_nodes.sensors.watches import BumperWatch, RangeWatch, RateWatch, SampleWatch
from sim_nodes.simulator import Simulator
from sim_nodes.ticks import TICK

BUMPER = "bumper"
LONGEST = 3600.0  # [s] maximum period for counting samples


def get_sensor_sample(simulator: Simulator, request: wire.SensorName) -> wire.SensorSample:
    simulation = simulator.simulation
    pipeline = simulation.pipeline(request.robot, request.sensor)
    pipeline.in_use = True
    if pipeline.latest is None:
        raise RequestRefused(
            Result.INCORRECT_STATE, f"no sample of {request.robot}/{request.sensor} has arrived yet; let time pass"
        )
    return sample_message(pipeline.latest, simulation.time_of_tick)


def watch_sensor(simulator: Simulator, request: wire.WatchSensor) -> None:
    simulator.simulation.pipeline(request.robot, request.sensor).in_use = True
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
    pipeline.in_use = True
    simulator.simulation.watch(request.id, BumperWatch(request.robot, BUMPER, request.zone, request.entity))


def watch_range(simulator: Simulator, request: wire.WatchRange) -> None:
    check_positive("distance", request.distance, "m")
    check_finite("bearings", request.start, request.end)
    pipeline = simulator.simulation.pipeline(request.robot, request.sensor)
    if len(pipeline.sensor.bearings) == 0:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"{request.robot}/{request.sensor} does not measure ranges: it has no beams"
        )
    pipeline.in_use = True
    watch = RangeWatch(request.robot, request.sensor, request.distance, request.start, request.end)
    simulator.simulation.watch(request.id, watch)


def check_rate(simulator: Simulator, request: wire.CheckRate) -> None:
    simulation = simulator.simulation
    if not TICK <= request.duration <= LONGEST:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid duration {request.duration:g} s for counting samples; expected {TICK:g} to {LONGEST:g} s",
        )
    if not 0.0 <= request.lowest <= request.highest:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid rate of {request.lowest:g} to {request.highest:g} samples per second; "
            "expected bounds of zero or more, the lower one first",
        )
    pipeline = simulation.pipeline(request.robot, request.sensor)
    pipeline.in_use = True
    end = simulation.tick + max(1, math.floor(request.duration / TICK + 0.5))
    watch = RateWatch(
        request.robot, request.sensor, pipeline.count, simulation.tick, end, request.lowest, request.highest
    )
    simulation.watch(request.id, watch)
