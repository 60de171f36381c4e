"""Simulating ahead of what is granted, and the way back.

A request takes longer than a grant of 20 ms is simulated in. A client that expects to grant more says so, and
gets the answers to many grants with one: that nothing happens up to a time. Should it ask for something before
that, the simulation goes back to where the client is, and comes there again in the same states to the bit, because
these do not depend on how time is granted.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import monotonic
from typing import Any

from sim_nodes.codec import copied
from sim_nodes.physics import Rewinds, UnstablePhysics
from sim_nodes.simulation import Simulation
from sim_nodes.stateful import State

LONGEST = 0.25  # [s] of the machine's clock, which decides how far it is gone, and not what happens there
SLICE = 0.5  # [s] simulated between two looks at it


@dataclass(frozen=True)
class Ahead:
    """Where a simulation was when it went ahead."""

    time: float  # [s]
    engine: Any
    state: State
    number: int  # of what had happened last


def go_ahead(simulation: Simulation, horizon: float) -> Ahead | None:
    """Simulate on to a horizon [s], to what happens first, or for as long as a client may be kept waiting.

    Returns:
        The way back; None if nothing was simulated.
    """
    engine = simulation.engine
    # What was shown or told cannot be taken back.
    shown = simulation.draws or simulation.streams.are_open or simulation.log.is_followed
    if horizon <= simulation.time or shown or not isinstance(engine, Rewinds):
        return None
    deadline = monotonic() + LONGEST
    checkpoint = engine.checkpoint()
    if checkpoint is None:
        return None
    # What is saved is in use, and goes on changing.
    ahead = Ahead(simulation.time, checkpoint, copied(simulation.save()), simulation.log.number)
    try:
        while simulation.time < horizon and not simulation.has_to_tell and monotonic() < deadline:
            simulation.advance(min(simulation.time + SLICE, horizon))
    except UnstablePhysics:  # to be told by the grant in which they get lost
        come_back(simulation, ahead, ahead.time)
        return None
    return ahead


def come_back(simulation: Simulation, ahead: Ahead, time: float) -> None:
    """Be at a time [s] again that has been passed since; the way back is used up by that."""
    assert isinstance(simulation.engine, Rewinds)
    simulation.engine.rewind(ahead.engine)
    simulation.restore(ahead.state)
    simulation.log.rewind(ahead.number)
    simulation.run(time)
