"""A lab of robots: how they are, leases by hand, and the emergency stop. All nodes with robots serve this.

Who has a robot is known by the node that serves it, and by nobody else; so there is no server of leases that could
be lost. An emergency stop is a request to each node and executor, which is acknowledged, and the same message
published on `emergency_key`, which reaches those, too, who are busy with something long.
"""

from __future__ import annotations

from typing import Any

from seoro.bridges.wire.message import Empty, Message, Verb

LONGEST_LEASE = 7 * 86_400.0  # [s]
MAX_TEXT = 500  # [characters] of what people say about leases and stops


class Stopped(Message):
    """An emergency stop that holds until it is released: by whom, why, and when [s since 1970]."""

    by: str
    reason: str = ""
    since: float = 0.0


class Lease(Message):
    """A lease by hand: its id, what for, and its end [s since 1970]."""

    lease: str
    purpose: str
    until: float


class TopicState(Message):
    """What a bridge hears of a robot on a topic.

    Attributes:
        topic: Its name.
        seen: How long ago the last message came [s]; None when none did.
        why: Why nothing is known by it, in words; empty if nothing is wrong.
    """

    topic: str
    seen: float | None = None
    why: str = ""


class RobotState(Message):
    """How a robot is, and who has it.

    Attributes:
        kinds: Types of actors that it can stand for, most specific first.
        battery: Charge, from 0 to 1; None when the node does not know.
        localised: Whether it knows where it is; None when it has nothing to know it by.
        deviation: Standard deviation of its position, as its localisation states it [m].
        position: Where it believes to be in the map: x and y [m].
        seen: How long ago it was last heard of [s]; None when it never was.
        holder: What it is held for; empty when nobody holds it.
        lease: The lease by hand that it is under.
        waiting: What those are for who wait for it, the next one first.
        stopped: The emergency stop of this robot; `LabState.stopped` is that of everything.
        topics: By what a bridge knows of it.
    """

    name: str
    kinds: tuple[str, ...]
    battery: float | None = None
    localised: bool | None = None
    deviation: float | None = None
    position: tuple[float, float] | None = None
    seen: float | None = None
    holder: str = ""
    lease: Lease | None = None
    waiting: tuple[str, ...] = ()
    stopped: Stopped | None = None
    topics: tuple[TopicState, ...] = ()


class LabState(Message):
    """How the robots of a node are; answered at any time. `kind` is `bridge` or the engine of a simulator.

    `received` and `sent` are when the request arrived and this left [s since 1970], by the clock of its machine.
    """

    kind: str
    version: str
    robots: tuple[RobotState, ...]
    stopped: Stopped | None = None
    clock: str = "real"  # or `granted`, where time passes while one run grants it
    holder: str = ""  # of all of it, where somebody has all
    received: float | None = None
    sent: float | None = None


class LeaseRobots(Message):
    """Keep robots for somebody, by an id of the client's: runs get them only if they name it.

    Asked again with the same id, it has a new end.
    """

    lease: str
    robots: tuple[str, ...]
    purpose: str = ""
    duration: float = 600.0  # [s]


class ReleaseLease(Message):
    """End a lease by its id, or all that a robot is under."""

    lease: str = ""
    robot: str = ""


class EmergencyStop(Message):
    """Stop everything that moves, or the named robots, and let them not move until that is released.

    A node that does not know `robots` stops everything.
    """

    by: str
    reason: str = ""
    robots: tuple[str, ...] = ()


class EmergencyStopped(Message):
    """The acknowledgement.

    Attributes:
        stopped: What was told to stand still: robots, or runs of an executor.
        took: How long that took from the arrival of the message [s].
        unsettled: Those of it whose goals have not ended yet, or may go on: whose robots reject to cancel them,
            or do not say that they have.
    """

    stopped: tuple[str, ...]
    took: float
    unsettled: tuple[str, ...] = ()


class ReleaseStop(Message):
    """Let everything move again, or the named robots: by whom, and why that is safe, which has to be said."""

    by: str
    reason: str
    robots: tuple[str, ...] = ()


GET_LAB_STATE = Verb("get_lab_state", Empty, LabState)
LEASE_ROBOTS = Verb("lease_robots", LeaseRobots, Empty)
RELEASE_LEASE = Verb("release_lease", ReleaseLease, Empty)
EMERGENCY_STOP = Verb("emergency_stop", EmergencyStop, EmergencyStopped, is_urgent=True)
RELEASE_STOP = Verb("release_stop", ReleaseStop, Empty)
LAB_VERBS: tuple[Verb[Any, Any], ...] = (GET_LAB_STATE, LEASE_ROBOTS, RELEASE_LEASE, EMERGENCY_STOP, RELEASE_STOP)
