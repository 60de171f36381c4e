"""Steps of MuJoCo, many at a time, and none in which a contact begins or ends unseen.

Looking for contacts after each step costs a tenth of the step itself. So MuJoCo counts them, for itself, in two
sensors that keep their last values: all contacts, and those of the floor. As long as the two are the same, nothing
else touches, and a batch is as good as single steps. Where they are not, the batch is taken back and made again
step by step, which gives the same states to the bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from sim_nodes.geometry import Array
from sim_nodes.mujoco.arm import MujocoArm
from sim_nodes.physics import FLOOR, UnstablePhysics

BATCH = 50  # steps that are made at once at most, and values that the sensors keep
ALL_CONTACTS, FLOOR_CONTACTS = "contacts/all", "contacts/floor"  # sensors
COUNT = [1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1]  # of a contact sensor: only their number
STATE = mujoco.mjtState.mjSTATE_INTEGRATION  # what the next steps depend on
LOST = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
NOTHING: frozenset[tuple[str, str]] = frozenset()


def add_counters(spec: Any) -> None:
    """Add the sensors that count contacts to the specification of a scene."""
    anything = mujoco.mjtObj.mjOBJ_UNKNOWN
    for name, kind, of in ((ALL_CONTACTS, anything, ""), (FLOOR_CONTACTS, mujoco.mjtObj.mjOBJ_GEOM, FLOOR)):
        spec.add_sensor(
            name=name,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=kind,
            objname=of,
            reftype=anything,
            intprm=COUNT,
            nsample=BATCH,
        )


class Stepper:
    """Makes the steps of a model.

    Args:
        model: The model, with the sensors of `add_counters`.
        data: Its data.
        owners: The entity of each geom.
        touching: The pairs in contact in the last step.
    """

    def __init__(
        self, model: Any, data: Any, owners: Sequence[str], touching: frozenset[tuple[str, str]] = NOTHING
    ) -> None:
        self._model, self._data, self._owners = model, data, owners
        self._timestep: float = model.opt.timestep
        self._time: float = data.time
        self._contacts = np.zeros((0, 2), dtype=np.int32)  # a view of MuJoCo's own, which stay where they are
        self._key = b""
        self.touching = touching
        self._before = np.zeros(mujoco.mj_stateSize(model, STATE))
        self._counts = [_kept(model, data, name) for name in (ALL_CONTACTS, FLOOR_CONTACTS)]

    @property
    def is_lost(self) -> bool:
        """Whether the physics were lost in a step."""
        return self._time == math.inf

    def make(self, count: int, arms: Sequence[MujocoArm]) -> int:
        """Make up to `count` steps; returns how many, fewer if the pairs in contact have changed in the last.

        Args:
            count: How many.
            arms: Those that move, which have to be led on after each step.

        Raises:
            UnstablePhysics: MuJoCo found no accelerations.
        """
        made = 0
        while made < count:
            wanted = min(count - made, BATCH)
            if not arms and self._batch(wanted):
                some, changed = wanted, False
            else:
                some, changed = self._singly(wanted, arms)
            self._check_time(some)
            made += some
            if changed:
                break
        return made

    def _batch(self, count: int) -> bool:
        """Make steps at once if nothing touches; returns whether they were made."""
        if count == 1 or self.touching:
            return False
        model, data = self._model, self._data
        mujoco.mj_getState(model, data, self._before, STATE)
        mujoco.mj_step(model, data, count)
        everything, floor = self._counts
        if everything.tobytes() == floor.tobytes():
            return True
        mujoco.mj_setState(model, data, self._before, STATE)
        return False

    def _singly(self, count: int, arms: Sequence[MujocoArm]) -> tuple[int, bool]:
        """Make steps until the pairs in contact change; returns how many, and whether they did."""
        model, data = self._model, self._data
        for made in range(1, count + 1):
            mujoco.mj_step(model, data)
            for arm in arms:
                arm.follow(data, self._timestep)
            # What stands on something touches it all the time: most steps end here.
            if (data.ncon != len(self._contacts) or self._contacts.tobytes() != self._key) and self._look():
                return made, True
        return count, False

    def _look(self) -> bool:
        """Find the pairs in contact; returns whether they are others than before."""
        self._contacts = self._data.contact.geom
        self._key = self._contacts.tobytes()
        touching = self._pairs(self._contacts.tolist())
        changed = touching != self.touching
        self.touching = touching
        return changed

    def _pairs(self, contacts: list[list[int]]) -> frozenset[tuple[str, str]]:
        pairs = set()
        for first, second in contacts:
            a, b = self._owners[first], self._owners[second]
            if a != b and FLOOR not in (a, b):
                pairs.add((min(a, b), max(a, b)))
        return frozenset(pairs)

    def _check_time(self, steps: int) -> None:
        """MuJoCo starts over, silently, when states are no numbers; in its first steps, its time does not tell."""
        time: float = self._data.time
        if time < self._time + (steps - 0.5) * self._timestep or (self._time == 0.0 and self._has_warned()):
            self._time = math.inf
            raise UnstablePhysics("MuJoCo found no accelerations: reset the simulation")
        self._time = time

    def _has_warned(self) -> bool:
        return any(self._data.warning[int(kind)].number for kind in LOST)


def _kept(model: Any, data: Any, name: str) -> Array:
    """The values that a counter has kept, in the order of a ring."""
    sensor = model.sensor(name).id
    # Before them stand what MuJoCo notes for itself, the place of the last in the ring, and the times of all.
    start = model.sensor_historyadr[sensor] + 2 + BATCH
    values: Array = data.history[start : start + BATCH]
    return values
