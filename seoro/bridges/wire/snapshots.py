"""Snapshots: the whole state of a simulation, which the same or another node goes on from."""

from __future__ import annotations

from enum import StrEnum

from seoro.bridges.wire.limits import BYTES, MAX_REQUEST, Limits
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.simulator import SimulatorFeatures

SNAPSHOT_FORMAT = 3


class Snapshot(Message):
    """A state of a simulation, with its world. `state` is for nodes of the same engine and version only."""

    format: int
    version: str  # of seoro
    engine: str
    engine_version: str
    world: str
    seed: int
    time: float  # of the simulator's clock [s]
    state: bytes
    digest: str  # of the state


class Purpose(StrEnum):
    """What a snapshot is restored for.

    `CONTINUE` goes on as if nothing had been between: clock, goals and watches by their ids, what was not told.
    `BEGIN` begins a run: the clock shows zero, nothing is watched for, and robots go on with their goals for
    nobody: the end is not reported, and the first command ends them or, if it is the same goal, takes them over.
    `REWIND` goes back within a run: the clock goes on, and so do watches; goals that are active now and were
    active then go on, others that are active now end as canceled, others that were active then go on for nobody.
    """

    CONTINUE = "continue"
    BEGIN = "begin"
    REWIND = "rewind"


class RestoreState(Message):
    """Restore a snapshot; what is drawn from there on follows from another seed, if there is one."""

    snapshot: Snapshot
    purpose: Purpose = Purpose.CONTINUE
    seed: int | None = None


SAVE_STATE = Verb("save_state", Empty, Snapshot, answers=BYTES)
RESTORE_STATE = Verb("restore_state", RestoreState, SimulatorFeatures, Limits(MAX_REQUEST))
