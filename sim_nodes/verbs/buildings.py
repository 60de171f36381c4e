"""Verbs about doors and lifts."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire.refusal import check_finite
from sim_nodes.buildings.watch import PositionWatch
from sim_nodes.outcomes import operation_failed
from sim_nodes.simulation import Simulation
from sim_nodes.simulator import Simulator

NEAR = 1e-6  # share of the opening, or [m]


def move_door(simulator: Simulator, request: wire.MoveDoor) -> None:
    simulation = simulator.simulation
    simulation.buildings.door(request.door)
    _check_share("opening", request.opening)
    simulation.move_building(request.door, request.opening, request.id)


def lock_door(simulator: Simulator, request: wire.LockDoor) -> None:
    simulation = simulator.simulation
    simulation.buildings.door(request.door)
    simulation.buildings.lock(request.door, locked=request.locked)


def watch_door(simulator: Simulator, request: wire.WatchDoor) -> None:
    simulation = simulator.simulation
    simulation.buildings.door(request.door)
    _check_share("range", request.least)
    _check_share("range", request.most)
    if request.least > request.most:
        raise operation_failed(
            f"invalid range {request.least:g} to {request.most:g}; expected the lower end first"
        )
    simulation.watch(request.id, PositionWatch(request.door, request.least - NEAR, request.most + NEAR))


def move_lift(simulator: Simulator, request: wire.MoveLift) -> None:
    simulation = simulator.simulation
    simulation.move_building(request.lift, _height(simulation, request.lift, request.floor), request.id)


def watch_lift(simulator: Simulator, request: wire.WatchLift) -> None:
    simulation = simulator.simulation
    height = _height(simulation, request.lift, request.floor)
    simulation.watch(request.id, PositionWatch(request.lift, height - NEAR, height + NEAR))


def _height(simulation: Simulation, lift: str, floor: int) -> float:
    """Return the height of a floor of a lift [m]."""
    floors = simulation.buildings.lift(lift).floors
    if not 0 <= floor < len(floors):
        raise operation_failed(f"unknown floor {floor} of {lift!r}; expected 0 to {len(floors) - 1}")
    return floors[floor]


def _check_share(what: str, value: float) -> None:
    check_finite(what, value)
    if not 0.0 <= value <= 1.0:
        raise operation_failed(f"invalid {what} {value:g} of a door; expected 0 (closed) to 1 (open)")
