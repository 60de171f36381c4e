"""States of MuJoCo, and steps in batches, which miss no begin or end of a contact.

Checking contacts after each step costs a tenth of the step. So sensors of MuJoCo, which keep their last values,
count all contacts, those with the floor and those with terrain. As long as the first number is the sum of the
others, nothing else touches, and a batch equals single steps. Otherwise, the batch is undone and repeated step by
step, which gives bit-identical states.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from hashlib import blake2b
from typing import Any

import mujoco
import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.mujoco.arm import MujocoArm
from sim_nodes.mujoco.terrain import TERRAIN_BODY
from sim_nodes.mujoco.work import BATCH, MotorWork
from sim_nodes.physics import FLOOR, UnstablePhysics, entity_pairs

ALL_CONTACTS, FLOOR_CONTACTS, TERRAIN_CONTACTS = "contacts/all", "contacts/floor", "contacts/terrain"  # sensors
COUNT = [1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1]  # a contact sensor that only counts
STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)  # for later steps; includes the warm start of the solver
DIVERGED = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
NOTHING: frozenset[tuple[str, str]] = frozenset()


def add_counters(spec: Any, *, has_terrain: bool) -> None:
    """Add the sensors that count contacts to a specification."""
    anything = mujoco.mjtObj.mjOBJ_UNKNOWN
    counted = [(ALL_CONTACTS, anything, ""), (FLOOR_CONTACTS, mujoco.mjtObj.mjOBJ_GEOM, FLOOR)]
    if has_terrain:
        counted.append((TERRAIN_CONTACTS, mujoco.mjtObj.mjOBJ_BODY, TERRAIN_BODY))
    for name, kind, of in counted:
        spec.add_sensor(
            name=name,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=kind,
            objname=of,
            reftype=anything,
            intprm=COUNT,
            nsample=BATCH,
        )


@dataclass(frozen=True)
class LastStep:
    """Results of the last step that MuJoCo computes anew only in the next."""

    touching: frozenset[tuple[str, str]]
    links: dict[str, frozenset[tuple[str, str]]]  # contacts of the links of each arm
    efforts: Array  # of all motors by degree of freedom


def state_of(model: Any, data: Any) -> Array:
    """Return the state of a simulation, shape (n,)."""
    state = np.zeros(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return state


def set_state(model: Any, data: Any, state: Array) -> None:
    """Set the state of a simulation, and update all positions."""
    mujoco.mj_setState(model, data, state, STATE)
    mujoco.mj_forward(model, data)
    # This has changed the warm start of the solver, which is part of the state.
    mujoco.mj_setState(model, data, state, STATE)


def digest_of(model: Any) -> bytes:
    """Return a digest of a compiled model; states are valid for the same model only."""
    size = mujoco.mj_sizeModel(model)
    buffer = np.zeros(size, dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return blake2b(buffer.tobytes(), digest_size=16).digest()


class Stepper:
    """Steps a model.

    Args:
        model: The model, with the sensors of `add_counters`.
        data: Its data.
        owners: Entity of each geom.
        work: Counts the steps, to sum the work of motors.
        touching: Pairs in contact in the last step.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        owners: Sequence[str],
        work: MotorWork,
        touching: frozenset[tuple[str, str]] = NOTHING,
    ) -> None:
        self._model, self._data, self._owners, self._work = model, data, owners, work
        self._timestep: float = model.opt.timestep
        self._time: float = data.time
        self._contacts = np.zeros((0, 2), dtype=np.int32)  # a view of MuJoCo's array, which does not move
        self._key = b""
        self.touching = touching
        self._before = np.zeros(mujoco.mj_stateSize(model, STATE))
        sensors = {model.sensor(index).name for index in range(model.nsensor)}
        counters = (ALL_CONTACTS, FLOOR_CONTACTS, TERRAIN_CONTACTS)
        self._counts = [_counter_values(model, data, name) for name in counters if name in sensors]

    @property
    def has_diverged(self) -> bool:
        """Whether the physics has diverged."""
        return self._time == math.inf

    def step(self, count: int, arms: Sequence[MujocoArm]) -> int:
        """Make up to `count` steps, to the first in which the pairs in contact change; returns their number.

        Args:
            count: Maximum number of steps.
            arms: Arms with moving targets, which are advanced after each step.

        Raises:
            UnstablePhysics: MuJoCo found no accelerations.
        """
        made = 0
        while made < count:
            wanted = min(count - made, BATCH)
            self._work.make_room(wanted)
            if not arms and self._batch(wanted):
                some, changed = wanted, False
            else:
                some, changed = self._singly(wanted, arms)
            self._check_time(some)
            self._work.count(some)
            made += some
            if changed:
                break
        return made

    def _batch(self, count: int) -> bool:
        """Make a batch if nothing touches; returns whether it was made."""
        if count == 1 or self.touching:
            return False
        model, data = self._model, self._data
        mujoco.mj_getState(model, data, self._before, STATE)
        mujoco.mj_step(model, data, count)
        everything, floor, *terrain = self._counts
        ground = floor + terrain[0] if terrain else floor
        if everything.tobytes() == ground.tobytes():
            return True
        mujoco.mj_setState(model, data, self._before, STATE)
        return False

    def _singly(self, count: int, arms: Sequence[MujocoArm]) -> tuple[int, bool]:
        """Make steps until the pairs in contact change; returns their number, and whether they changed."""
        model, data = self._model, self._data
        for made in range(1, count + 1):
            mujoco.mj_step(model, data)
            for arm in arms:
                arm.advance_targets(data, self._timestep)
            # Standing bodies touch something all the time: most steps end here.
            if (
                data.ncon != len(self._contacts) or self._contacts.tobytes() != self._key
            ) and self._update_contacts():
                return made, True
        return count, False

    def _update_contacts(self) -> bool:
        """Update the pairs in contact; returns whether they changed."""
        self._contacts = self._data.contact.geom
        self._key = self._contacts.tobytes()
        touching = entity_pairs(self._contacts.tolist(), self._owners)
        changed = touching != self.touching
        self.touching = touching
        return changed

    def _check_time(self, steps: int) -> None:
        """Detect a silent restart of MuJoCo after invalid states; its time does not show it at first."""
        time: float = self._data.time
        has_warned = any(self._data.warning[int(kind)].number for kind in DIVERGED) if self._time == 0.0 else False
        if time < self._time + (steps - 0.5) * self._timestep or has_warned:
            self._time = math.inf
            raise UnstablePhysics("MuJoCo found no accelerations: reset the simulation")
        self._time = time


def _counter_values(model: Any, data: Any, name: str) -> Array:
    """Return the values that a counter has kept, in ring order."""
    sensor = model.sensor(name).id
    # They follow MuJoCo's own header: the position of the last value in the ring, and all times.
    start = model.sensor_historyadr[sensor] + 2 + BATCH
    values: Array = data.history[start : start + BATCH]
    return values
