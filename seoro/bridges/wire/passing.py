"""Grants of time, and what happens in them."""

from __future__ import annotations

from enum import StrEnum

from seoro.bridges.wire.feedback import NavigationFeedback
from seoro.bridges.wire.message import Empty, Message, Verb


class Outcome(StrEnum):
    """How a goal ended (as in ROS `action_msgs/GoalStatus`)."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Occurrence(Message):
    """A goal that ended or a watch that fired, by the id its client gave it."""

    id: str
    time: float
    outcome: Outcome
    message: str = ""


class Contact(Message):
    """Two entities began to touch; contact with the floor is not reported."""

    time: float
    first: str
    second: str


class Advance(Message):
    """Grant of time: simulate to `until`, or to the first occurrence, contact or feedback before it."""

    until: float


class Advanced(Message):
    """Answer to a grant: the time that was reached and everything that happened up to it, in order."""

    time: float
    occurrences: tuple[Occurrence, ...] = ()
    contacts: tuple[Contact, ...] = ()
    film: bytes = b""  # the next part of what is recorded, since the last answer
    film_error: str = ""  # why nothing more is recorded
    feedback: tuple[NavigationFeedback, ...] = ()


class CancelGoal(Message):
    """Cancel a goal: the robot stops, the goal ends as canceled. Unknown and ended goals are NOT_FOUND."""

    id: str


class CancelWatch(Message):
    """Forget a watch; unknown and fired ones are NOT_FOUND."""

    id: str


ADVANCE = Verb("advance", Advance, Advanced)
CANCEL_GOAL = Verb("cancel_goal", CancelGoal, Empty)
CANCEL_WATCH = Verb("cancel_watch", CancelWatch, Empty)
