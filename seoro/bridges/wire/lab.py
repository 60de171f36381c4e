"""Lab of robots: states, leases by hand, and the emergency stop. All nodes with robots serve these verbs.

Only the node of a robot knows its holder. So no lease server can fail. An emergency stop is sent as
a request to each node and executor, which acknowledge it. It is also published on `emergency_key`, which reaches
busy nodes, too.
"""

from __future__ import annotations

from seoro.bridges.wire.message import Empty, Message, Query, Verb
from seoro.bridges.wire.simulator import RobotName
from seoro.security.keys.roles import Role

LONGEST_LEASE = 7 * 86_400.0  # [s]
MAX_TEXT = 500  # [characters] of purposes and reasons of leases and stops


class ActiveStop(Message):
    """Emergency stop until its release: its sender, reason and time [s since 1970]."""

    by: str
    reason: str = ""
    since: float = 0.0


class Lease(Message):
    """Lease by hand: its id, purpose and end [s since 1970]."""

    lease: str
    purpose: str
    until: float


class TopicState(Message):
    """State of a topic of a robot, as a bridge receives it.

    Attributes:
        topic: Name of the topic.
        seen: Age of the last message [s]; None if none was received.
        why: Reason why the topic is unusable; empty without a problem.
    """

    topic: str
    seen: float | None = None
    why: str = ""


class RobotHealth(Message):
    """Health of a robot.

    Attributes:
        battery: Charge, from 0 to 1; None if unknown.
        localised: Whether it is localised; None without localisation.
        deviation: Standard deviation of its position, stated by its localisation [m].
        position: Estimated position in the map: x and y [m].
        seen: Age of the last message of the robot [s]; None if none was received.
        topics: Topics received by the bridge.
    """

    battery: float | None = None
    localised: bool | None = None
    deviation: float | None = None
    position: tuple[float, float] | None = None
    seen: float | None = None
    topics: tuple[TopicState, ...] = ()


class RobotState(RobotHealth):
    """State of a robot, and its holder.

    Attributes:
        name: Name of the robot.
        kinds: Types of actors that it can play, most specific first.
        holder: Purpose of its holder; empty if it is free.
        lease: Lease by hand of the robot.
        waiting: Purposes of the clients in its wait queue, the next one first.
        stopped: Emergency stop of this robot; `LabState.stopped` is that of all robots.
    """

    name: str
    kinds: tuple[str, ...]
    holder: str = ""
    lease: Lease | None = None
    waiting: tuple[str, ...] = ()
    stopped: ActiveStop | None = None


class RobotProblem(Message):
    """Problem of a robot, found by a check.

    Attributes:
        text: The found problem, and the expected state.
        help: Suggestion for a fix.
        is_fatal: Whether scenarios with the robot fail; otherwise some may pass.
    """

    text: str
    help: str = ""
    is_fatal: bool = True


class RobotCheck(Message):
    """Problems of a robot; none if it is well."""

    problems: tuple[RobotProblem, ...] = ()


class LabState(Message):
    """State of the robots of a node, sent at any time. `kind` is `bridge` or the engine of a simulator.

    `received` and `sent` are the arrival of the request and the departure of the reply, by the clock of the node
    [s since 1970].
    """

    kind: str
    version: str
    robots: tuple[RobotState, ...]
    stopped: ActiveStop | None = None
    clock: str = "real"  # or `granted`, if time passes only by the grants of a run
    holder: str = ""  # purpose of the holder of the whole node
    received: float | None = None
    sent: float | None = None


class LeaseRobots(Message):
    """Lease robots under an id that the client chooses: only runs that name this id can acquire them.

    A repetition with the same id sets a new end.
    """

    lease: str
    robots: tuple[str, ...]
    purpose: str = ""
    duration: float = 600.0  # [s]


class ReleaseLease(Message):
    """End a lease by its id, or all leases of a robot."""

    lease: str = ""
    robot: str = ""


class EmergencyStop(Message):
    """Stop all robots, or the named ones, until a release.

    A node that does not know the field `robots` stops all.
    """

    by: str
    reason: str = ""
    robots: tuple[str, ...] = ()


class StopAcknowledgement(Message):
    """Acknowledgement of an emergency stop.

    Attributes:
        stopped: Stopped robots, or runs of an executor.
        took: Duration from the arrival of the message [s].
        unsettled: Robots whose goals may continue: they reject the cancellation, or do not answer.
    """

    stopped: tuple[str, ...]
    took: float
    unsettled: tuple[str, ...] = ()


class ReleaseStop(Message):
    """Release the emergency stop of all robots, or of the named ones. The reason is required."""

    by: str
    reason: str
    robots: tuple[str, ...] = ()


GET_LAB_STATE = Query("get_lab_state", Empty, LabState, role=Role.VIEWER)
CHECK_ROBOT = Query("check_robot", RobotName, RobotCheck, role=Role.VIEWER)  # of bridges only
LEASE_ROBOTS = Verb("lease_robots", LeaseRobots, Empty, is_audited=True)
RELEASE_LEASE = Verb("release_lease", ReleaseLease, Empty, is_audited=True)
EMERGENCY_STOP = Verb(
    "emergency_stop", EmergencyStop, StopAcknowledgement, is_audited=True, is_stop=True, is_urgent=True
)
RELEASE_STOP = Verb("release_stop", ReleaseStop, Empty, is_audited=True)
