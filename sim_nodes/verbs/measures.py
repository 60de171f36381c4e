"""Verbs that watch measures of robots and other entities."""

from __future__ import annotations

from dataclasses import astuple

from seoro.bridges import wire
from seoro.bridges.wire.refusal import check_finite
from seoro.robotics.measures import ONLY_DRIVING, Measure
from sim_nodes.measure_watch import MeasureWatch
from sim_nodes.outcomes import feature_unsupported, operation_failed, unknown
from sim_nodes.physics import MeasuresWork
from sim_nodes.simulation import Simulation
from sim_nodes.simulator import Simulator


def watch_measure(simulator: Simulator, request: wire.WatchMeasure) -> None:
    simulation, name, limit = simulator.simulation, request.entity, request.limit
    check_finite("limit", limit.value)
    check_finite("area", *astuple(limit.area))
    if limit.area.x_min > limit.area.x_max or limit.area.y_min > limit.area.y_max:
        raise operation_failed(f"invalid area {astuple(limit.area)}; expected lower corners before upper ones")
    state = simulation.entities.state(name)
    if limit.measure in ONLY_DRIVING:
        _ = simulation.robot(name).mobile  # refuses robots that do not drive
    if limit.measure is Measure.WORK:
        _measure_work(simulation, name)
    known = simulation.run_data.clearances.names
    if limit.measure is Measure.CLEARANCE and limit.other and limit.other not in known:
        raise unknown(f"entity {limit.other!r} to keep clear of", "walls, bodies and driving robots", known)
    if limit.other == name:
        raise operation_failed(f"invalid clearance of {name!r} to itself; expected another entity")
    x, y, _ = state.position
    work = simulation.work(name) or 0.0
    simulation.watch(request.id, MeasureWatch(name, limit, simulation.tick, (x, y), work))


def _measure_work(simulation: Simulation, name: str) -> None:
    """Measure the work of a robot exactly; refuse other entities, and engines that do not know it."""
    simulation.robot(name)
    if not isinstance(simulation.engine, MeasuresWork):
        raise feature_unsupported(f"the engine {simulation.engine.name} does not measure the work of motors")
    simulation.measure_work(name)
