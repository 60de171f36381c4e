"""Verbs about sensors of robots."""

from __future__ import annotations

import math

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_id, check_positive
from sim_nodes.samples import sample_message
from sim_nodes.sensors.bumper import Bumper
from sim_nodes.sensors.watches import BumperWatch, RangeWatch, RateWatch, SampleWatch
from sim_nodes.simulator import Simulator
from sim_nodes.ticks import TICK
from sim_nodes.verbs.handling import Handling

BUMPER = "bumper"
LONGEST = 3600.0  # [s] in which samples are counted


def _get_sensor_sample(simulator: Simulator, request: wire.SensorName) -> wire.SensorSample:
    simulation = simulator.simulation
    feed = simulation.feed(request.robot, request.sensor)
    feed.in_use = True
    if feed.latest is None:
        raise RequestRefused(
            Result.INCORRECT_STATE, f"no sample of {request.robot}/{request.sensor} has arrived yet: let time pass"
        )
    return sample_message(feed.latest, simulation.time_of_tick)


def _watch_sensor(simulator: Simulator, request: wire.WatchSensor) -> Empty:
    check_id(request.id)
    simulator.simulation.feed(request.robot, request.sensor).in_use = True
    simulator.simulation.watch(request.id, SampleWatch(request.robot, request.sensor, simulator.simulation.tick))
    return Empty()


def _watch_bumper(simulator: Simulator, request: wire.WatchBumper) -> Empty:
    check_id(request.id)
    feed = simulator.simulation.feed(request.robot, BUMPER)
    assert isinstance(feed.sensor, Bumper)
    zones = feed.sensor.zones
    if request.zone and request.zone not in zones:
        raise RequestRefused(
            Result.NOT_FOUND,
            f"the bumper of {request.robot} has no zone {request.zone!r}: it has {', '.join(zones)}",
        )
    feed.in_use = True
    simulator.simulation.watch(request.id, BumperWatch(request.robot, BUMPER, request.zone, request.entity))
    return Empty()


def _watch_range(simulator: Simulator, request: wire.WatchRange) -> Empty:
    check_id(request.id)
    check_positive("distance", request.distance, "m")
    check_finite("bearings", request.start, request.end)
    feed = simulator.simulation.feed(request.robot, request.sensor)
    if len(feed.sensor.bearings) == 0:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"{request.robot}/{request.sensor} measures no ranges: it has no beams"
        )
    feed.in_use = True
    watch = RangeWatch(request.robot, request.sensor, request.distance, request.start, request.end)
    simulator.simulation.watch(request.id, watch)
    return Empty()


def _check_rate(simulator: Simulator, request: wire.CheckRate) -> Empty:
    check_id(request.id)
    simulation = simulator.simulation
    if not TICK <= request.duration <= LONGEST:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"samples are counted for {TICK:g} to {LONGEST:g} s, not for {request.duration:g} s",
        )
    if not 0.0 <= request.lowest <= request.highest:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"a rate of {request.lowest:g} to {request.highest:g} samples a second is none: "
            "the bounds are zero or more, the lower one first",
        )
    feed = simulation.feed(request.robot, request.sensor)
    feed.in_use = True
    end = simulation.tick + max(1, math.floor(request.duration / TICK + 0.5))
    watch = RateWatch(
        request.robot, request.sensor, feed.count, simulation.tick, end, request.lowest, request.highest
    )
    simulation.watch(request.id, watch)
    return Empty()


HANDLERS: tuple[Handling, ...] = (
    (wire.GET_SENSOR_SAMPLE, _get_sensor_sample),
    (wire.WATCH_SENSOR, _watch_sensor),
    (wire.WATCH_BUMPER, _watch_bumper),
    (wire.WATCH_RANGE, _watch_range),
    (wire.CHECK_RATE, _check_rate),
)
