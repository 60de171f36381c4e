"""Motion of an entity in a tick."""

from __future__ import annotations

from dataclasses import dataclass

from sim_nodes.physics import BodyState


@dataclass(frozen=True)
class Sample:
    """Motion of an entity in a tick: its base, and the joints of its arm [rad, m] with their rates."""

    tick: int
    base: BodyState
    joints: tuple[float, ...] = ()
    rates: tuple[float, ...] = ()
