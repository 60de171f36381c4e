"""Grants of time, and what happens in them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum

from seoro.bridges.wire.feedback import NavigationFeedback
from seoro.bridges.wire.geometry import Vector3
from seoro.bridges.wire.limits import MAX_MESSAGE, Limits
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.simulator import SimulationTime


class Outcome(StrEnum):
    """How a goal ended (as in ROS `action_msgs/GoalStatus`)."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Occurrence(Message):
    """A goal that ended or a watch that fired, by the id its client gave it.

    A goal that the node ended for a reason of its own is `interrupted`: its holder was lost, an emergency stop
    came, or the node has a fault. That is no verdict on the robot.
    """

    id: str
    time: float
    outcome: Outcome
    message: str = ""
    interrupted: bool = False


class Contact(Message):
    """Two entities began to touch, or a robot began to push what it touches; without contact with the floor.

    Attributes:
        time: Of the simulator's clock [s].
        first: Name of one.
        second: Name of the other.
        strikers: Who moved into the other, robots also for what they hold; None if the node cannot say.
        position: Of a point of contact [m]; None if the node has none.
        held: What of the two a robot holds, and which robot.
        pushes: Whether the two touched before, and a striker began to push.
    """

    time: float
    first: str
    second: str
    strikers: tuple[str, ...] | None = None
    position: Vector3 | None = None
    held: Mapping[str, str] = {}
    pushes: bool = False


class Departure(Message):
    """A robot that left its world.

    Attributes:
        time: Of the simulator's clock [s].
        robot: Name of the robot.
        position: Of its base in the map [m].
        extent: Lower x, lower y, upper x, upper y of the world [m].
    """

    time: float
    robot: str
    position: Vector3
    extent: tuple[float, float, float, float]


class Advance(Message):
    """Grant of time: simulate to `until`, or to the first occurrence, contact or feedback before it.

    A client that expects to grant up to a `horizon` without asking for anything before may say so: the node then
    simulates ahead to it, or to what happens first, and `rewind` takes that back.
    """

    until: float
    horizon: float | None = None


class Advanced(Message):
    """Answer to a grant: the time that was reached and everything that happened up to it, in order.

    When that is after `until`, nothing happened before.
    """

    time: float
    occurrences: tuple[Occurrence, ...] = ()
    contacts: tuple[Contact, ...] = ()
    film: bytes = b""  # the next part of what is recorded, since the last answer
    film_error: str = ""  # why nothing more is recorded
    feedback: tuple[NavigationFeedback, ...] = ()
    departures: tuple[Departure, ...] = ()  # none from nodes that do not know the ends of their worlds


class Rewind(Message):
    """Take back what was simulated ahead of `time`.

    That is possible up to the next request after the grant that had a horizon; otherwise the time stays as it is.
    """

    time: float


class CancelGoal(Message):
    """Cancel a goal: the robot stops, the goal ends as canceled. Unknown and ended goals are NOT_FOUND."""

    id: str


class CancelWatch(Message):
    """Forget a watch; unknown and fired ones are NOT_FOUND."""

    id: str


HAPPENED = Limits(MAX_MESSAGE, 1_000_000)  # of 10,000 things at once, or a part of a film

ADVANCE = Verb("advance", Advance, Advanced, answers=HAPPENED)
REWIND = Verb("rewind", Rewind, SimulationTime)
CANCEL_GOAL = Verb("cancel_goal", CancelGoal, Empty)
CANCEL_WATCH = Verb("cancel_watch", CancelWatch, Empty)


def steps_until(time: float, steps_per_second: int) -> int:
    """The number of steps from zero to the first that ends at or after a time [s], as a grant makes them."""
    steps = math.ceil(time * steps_per_second)
    # The product is rounded, so that it may be off by one.
    while steps / steps_per_second < time:
        steps += 1
    while (steps - 1) / steps_per_second >= time:
        steps -= 1
    return steps
