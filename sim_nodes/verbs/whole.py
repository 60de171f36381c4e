"""Verbs about the simulator as a whole, and grants of time."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _get_simulator_features(simulator: Simulator, _: Empty) -> wire.SimulatorFeatures:
    return simulator.features()


def _load_world(simulator: Simulator, request: wire.LoadWorld) -> wire.SimulatorFeatures:
    simulator.load(request.world, request.seed)
    return simulator.features()


def _change_world(simulator: Simulator, request: wire.ChangeWorld) -> wire.SimulatorFeatures:
    simulator.change(request.world, request.robots)
    return simulator.features()


def _unload_world(simulator: Simulator, _: Empty) -> Empty:
    simulator.unload()
    return Empty()


def _set_simulation_state(simulator: Simulator, request: wire.SetSimulationState) -> Empty:
    simulator.set_state(request.state, request.rate)
    return Empty()


def _step_simulation(simulator: Simulator, request: wire.StepSimulation) -> wire.SimulationTime:
    return wire.SimulationTime(time=simulator.step(request.steps))


def _reset_simulation(simulator: Simulator, request: wire.ResetSimulation) -> Empty:
    simulator.reset(request.scope)
    return Empty()


def _advance(simulator: Simulator, request: wire.Advance) -> wire.Advanced:
    return simulator.advance(request.until, request.horizon)


def _rewind(simulator: Simulator, request: wire.Rewind) -> wire.SimulationTime:
    return wire.SimulationTime(time=simulator.rewind(request.time))


def _cancel_goal(simulator: Simulator, request: wire.CancelGoal) -> Empty:
    simulator.simulation.cancel_goal(request.id)
    return Empty()


def _cancel_watch(simulator: Simulator, request: wire.CancelWatch) -> Empty:
    simulator.simulation.cancel_watch(request.id)
    return Empty()


HANDLERS: tuple[Handling, ...] = (
    (wire.GET_SIMULATOR_FEATURES, _get_simulator_features),
    (wire.LOAD_WORLD, _load_world),
    (wire.CHANGE_WORLD, _change_world),
    (wire.UNLOAD_WORLD, _unload_world),
    (wire.SET_SIMULATION_STATE, _set_simulation_state),
    (wire.STEP_SIMULATION, _step_simulation),
    (wire.RESET_SIMULATION, _reset_simulation),
    (wire.ADVANCE, _advance),
    (wire.REWIND, _rewind),
    (wire.CANCEL_GOAL, _cancel_goal),
    (wire.CANCEL_WATCH, _cancel_watch),
)
