"""Snapshots."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _save_state(simulator: Simulator, _: Empty) -> wire.Snapshot:
    return simulator.save()


def _restore_state(simulator: Simulator, request: wire.RestoreState) -> wire.SimulatorFeatures:
    simulator.restore(request.snapshot, request.purpose, request.seed)
    return simulator.features()


HANDLERS: tuple[Handling, ...] = ((wire.SAVE_STATE, _save_state), (wire.RESTORE_STATE, _restore_state))
