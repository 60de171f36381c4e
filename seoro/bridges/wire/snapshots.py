"""Snapshots: the whole state of a simulation, which the same or another node can resume."""

from __future__ import annotations

from enum import StrEnum

from seoro.bridges.wire.limits import BYTES, MAX_REQUEST, Limits
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.simulator import SimulatorFeatures

SNAPSHOT_FORMAT = 3


class Snapshot(Message):
    """State of a simulation, with its world. Only nodes of the same engine and version can restore `state`."""

    format: int
    version: str  # of seoro
    engine: str
    engine_version: str
    world: str
    seed: int
    time: float  # time of the simulator's clock [s]
    state: bytes
    digest: str  # digest of the state


class Purpose(StrEnum):
    """Purpose of restoring a snapshot.

    `CONTINUE` resumes the saved state: clock, goals and watches by their ids, and unsent events. `BEGIN` starts a
    run, with the clock at zero and without watches. Robots continue their goals without reporting the end; the
    first command ends them or, if it is the same goal, adopts them. `REWIND` goes back within a run: clock and
    watches continue. Goals that are active both now and in the snapshot continue. Others that are active now end
    as canceled; others of the snapshot continue without reporting.
    """

    CONTINUE = "continue"
    BEGIN = "begin"
    REWIND = "rewind"


class RestoreState(Message):
    """Restore a snapshot; `seed` replaces the seed of all later random values."""

    snapshot: Snapshot
    purpose: Purpose = Purpose.CONTINUE
    seed: int | None = None


SAVE_STATE = Verb("save_state", Empty, Snapshot, reply_limits=BYTES)
RESTORE_STATE = Verb("restore_state", RestoreState, SimulatorFeatures, Limits(MAX_REQUEST))
