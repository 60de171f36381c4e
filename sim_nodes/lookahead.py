"""Simulates ahead of granted time, and goes back.

A request takes longer than the simulation of a 20 ms grant. So a client may announce a horizon, and one answer
then covers many grants: nothing happens until a given time. If the client does ask for something earlier, the
simulation returns to the client's time and replays from there. The replayed states are bit-identical, because they
do not depend on how time is granted.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import monotonic
from typing import Any

from sim_nodes.codec import deep_copy
from sim_nodes.physics import Rewinds, UnstablePhysics
from sim_nodes.simulation import Simulation
from sim_nodes.stateful import State

LONGEST = 0.25  # [s] wall time; affects the time that is reached, not the results
SLICE = 0.5  # [s] simulated between two checks of the wall clock


@dataclass(frozen=True)
class Lookahead:
    """State of a simulation before it went ahead."""

    time: float  # [s]
    engine: Any
    state: State
    number: int  # number of the last event


def simulate_ahead(simulation: Simulation, horizon: float) -> Lookahead | None:
    """Simulate to a horizon [s], to the next event, or for as long as a client may be kept waiting.

    Returns:
        The state to return to; None if nothing was simulated.
    """
    engine = simulation.engine
    # Streamed, recorded and followed output cannot be withdrawn.
    shown = simulation.is_rendering or simulation.streams.are_open or simulation.log.is_followed
    if horizon <= simulation.time or shown or not isinstance(engine, Rewinds):
        return None
    deadline = monotonic() + LONGEST
    checkpoint = engine.checkpoint()
    if checkpoint is None:
        return None
    # Saved data shares objects with the running simulation, hence the copy.
    ahead = Lookahead(simulation.time, checkpoint, deep_copy(simulation.save()), simulation.log.number)
    try:
        while simulation.time < horizon and not simulation.has_pending_events and monotonic() < deadline:
            simulation.advance(min(simulation.time + SLICE, horizon))
    except UnstablePhysics:  # reported by the grant that reaches it
        return_to(simulation, ahead, ahead.time)
        return None
    return ahead


def return_to(simulation: Simulation, ahead: Lookahead, time: float) -> None:
    """Return to a time [s] that has been passed; consumes `ahead`."""
    assert isinstance(simulation.engine, Rewinds)
    simulation.engine.rewind(ahead.engine)
    simulation.restore(ahead.state)
    simulation.log.rewind(ahead.number)
    simulation.run(time)
