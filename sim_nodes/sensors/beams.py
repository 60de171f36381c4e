"""Beams without a return because of faults."""

from __future__ import annotations

import math
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from seoro.bridges.wire import BeamLoss, DeadBeams, DeadSector
from sim_nodes.geometry import Array

Beams = NDArray[np.intp]
BeamFault = BeamLoss | DeadSector | DeadBeams


def blind_beams(fault: BeamFault, bearings: Array, random: np.random.Generator) -> Beams:
    """Return the indices of the beams that a fault makes blind in a scan; `random` belongs to the scan."""
    match fault:
        case BeamLoss(share=share):
            return random.choice(len(bearings), lost_beams(share, len(bearings)), replace=False)
        case DeadSector() | DeadBeams():
            return dead_beams(fault, bearings)
        case _:
            assert_never(fault)


def lost_beams(share: float, count: int) -> int:
    """Return the number of beams for a share; 0.29 of 100 are 29, despite the rounding of floats."""
    return int(share * count + 1e-9)


def dead_beams(fault: DeadSector | DeadBeams, bearings: Array) -> Beams:
    """Return the indices of the beams that a fault makes blind in every scan."""
    match fault:
        case DeadSector(start=start, end=end):
            turn = 2.0 * math.pi
            width = (end - start) % turn or turn  # a sector that ends where it starts is the full circle
            return np.flatnonzero((bearings - start) % turn <= width)
        case DeadBeams(beams=beams):
            return np.array(beams, dtype=np.intp)
        case _:
            assert_never(fault)
