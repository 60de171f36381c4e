"""Verbs about what is published while time passes."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _open_stream(simulator: Simulator, request: wire.OpenStream) -> Empty:
    simulator.streams.open(request, simulator.simulation)
    return Empty()


def _close_stream(simulator: Simulator, request: wire.StreamName) -> Empty:
    simulator.streams.close(request.id)
    return Empty()


HANDLERS: tuple[Handling, ...] = (
    (wire.OPEN_STREAM, _open_stream),
    (wire.CLOSE_STREAM, _close_stream),
)
