"""Verbs about faults."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty
from seoro.bridges.wire.refusal import check_id
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _inject_fault(simulator: Simulator, request: wire.InjectFault) -> Empty:
    check_id(request.id)
    simulator.simulation.inject_fault(request.id, request.robot, request.device, request.fault, request.limit)
    return Empty()


def _clear_faults(simulator: Simulator, request: wire.ClearFaults) -> Empty:
    simulator.simulation.faults_of(request.robot).clear(request.device, request.kind)
    return Empty()


HANDLERS: tuple[Handling, ...] = (
    (wire.INJECT_FAULT, _inject_fault),
    (wire.CLEAR_FAULTS, _clear_faults),
)
