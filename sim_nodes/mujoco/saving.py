"""The state of a MuJoCo simulation as an array."""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b
from typing import Any

import mujoco
import numpy as np

from sim_nodes.geometry import Array

# With it a simulation goes on to the bit. `mjSTATE_FULLPHYSICS` is without what the solver starts from.
EVERYTHING = int(mujoco.mjtState.mjSTATE_INTEGRATION)


@dataclass(frozen=True)
class LastStep:
    """What MuJoCo knows of the step that led to a state, and computes anew only in the next."""

    touching: frozenset[tuple[str, str]]
    links: dict[str, frozenset[tuple[str, str]]]  # of each arm: what its links touch
    efforts: Array  # of all motors, by degree of freedom


def state_of(model: Any, data: Any) -> Array:
    """The state of a simulation, shape (n,)."""
    state = np.zeros(mujoco.mj_stateSize(model, EVERYTHING))
    mujoco.mj_getState(model, data, state, EVERYTHING)
    return state


def set_state(model: Any, data: Any, state: Array) -> None:
    """Put a simulation into a state, and compute the places of everything from it."""
    mujoco.mj_setState(model, data, state, EVERYTHING)
    mujoco.mj_forward(model, data)
    # That has told the solver where to start next, which is part of the state.
    mujoco.mj_setState(model, data, state, EVERYTHING)


def digest_of(model: Any) -> bytes:
    """A digest of everything that a compiled model says: a state means nothing in another one."""
    size = mujoco.mj_sizeModel(model)
    buffer = np.zeros(size, dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return blake2b(buffer.tobytes(), digest_size=16).digest()
