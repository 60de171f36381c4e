"""Verbs about films."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _start_recording(simulator: Simulator, request: wire.StartRecording) -> Empty:
    simulator.simulation.films.start(request)
    return Empty()


def _stop_recording(simulator: Simulator, _: Empty) -> wire.Recorded:
    film, error = simulator.simulation.films.stop()
    return wire.Recorded(film=film, error=error)


HANDLERS: tuple[Handling, ...] = (
    (wire.START_RECORDING, _start_recording),
    (wire.STOP_RECORDING, _stop_recording),
)
