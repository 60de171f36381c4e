"""Verbs about what is published while time passes, and about what happens then."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _open_stream(simulator: Simulator, request: wire.OpenStream) -> Empty:
    simulator.streams.open(request, simulator.simulation)
    return Empty()


def _close_stream(simulator: Simulator, request: wire.StreamName) -> Empty:
    simulator.streams.close(request.id)
    return Empty()


def _await_happenings(simulator: Simulator, request: wire.AwaitHappenings) -> wire.Happenings:
    """What has happened by now; whoever serves this lets those wait who want to (`sim_nodes.waiting`)."""
    if not 0.0 <= request.wait <= wire.LONGEST_WAIT:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"a client waits for 0 to {wire.LONGEST_WAIT:g} s, not for {request.wait} s"
        )
    return simulator.log.since(request.since)


HANDLERS: tuple[Handling, ...] = (
    (wire.OPEN_STREAM, _open_stream),
    (wire.CLOSE_STREAM, _close_stream),
    (wire.AWAIT_HAPPENINGS, _await_happenings),
)
