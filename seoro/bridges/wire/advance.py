"""Grants of time, and the events in them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum

from seoro.bridges.wire.limits import MAX_MESSAGE, Limits
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.mobile import NavigationFeedback
from seoro.bridges.wire.simulator import SimulationTime
from seoro.bridges.wire.tracks import TrackSample
from seoro.robotics.geometry import Position3D


class Outcome(StrEnum):
    """End of a goal (as in ROS `action_msgs/GoalStatus`)."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Occurrence(Message):
    """End of a goal or firing of a watch, by the id that its client chose.

    A goal is `interrupted` if the node ended it for a reason of its own: a lost holder, an emergency stop, or a
    fault of the node. This is not a verdict on the robot.

    `margin` of a watch of a measure is the distance of the measure to the limit in its unit, at most 0.
    """

    id: str
    time: float
    outcome: Outcome
    message: str = ""
    interrupted: bool = False
    margin: float | None = None


class Contact(Message):
    """Two entities began to touch, or a robot began to push an entity that it touches; the floor is ignored.

    Attributes:
        time: Time of the simulator's clock [s].
        first: Name of one entity.
        second: Name of the other entity.
        strikers: Entities that moved into the other, robots also for held entities; None if unknown.
        position: Position of a point of contact [m]; None if unknown.
        held: The entity that a robot holds, mapped to this robot.
        pushes: Whether the two touched before, and a striker began to push.
    """

    time: float
    first: str
    second: str
    strikers: tuple[str, ...] | None = None
    position: Position3D | None = None
    held: Mapping[str, str] = {}
    pushes: bool = False


class Departure(Message):
    """Departure of a robot from its world.

    Attributes:
        time: Time of the simulator's clock [s].
        robot: Name of the robot.
        position: Position of its base in the map [m].
        extent: Lower x, lower y, upper x, upper y of the world [m].
    """

    time: float
    robot: str
    position: Position3D
    extent: tuple[float, float, float, float]


class Advance(Message):
    """Grant of time: simulate to `until`, or to the first occurrence, contact or feedback before it.

    A client may announce a `horizon` up to which it expects to grant time without other requests. The node then
    simulates ahead to it, or to the first event, and `rewind` undoes that. Clients that collect feedback report it
    at its times, so it does not end the simulation ahead.
    """

    until: float
    horizon: float | None = None
    collects_feedback: bool = False


class Advanced(Message):
    """Reply to a grant: the reached time and all events up to it, in order.

    A time after `until` means that no event occurred before, except collected feedback.
    """

    time: float
    occurrences: tuple[Occurrence, ...] = ()
    contacts: tuple[Contact, ...] = ()
    film: bytes = b""  # next part of the recording
    film_error: str = ""  # reason why the recording ended
    feedback: tuple[NavigationFeedback, ...] = ()
    departures: tuple[Departure, ...] = ()  # empty from nodes that do not know the extent of their world
    tracks: tuple[TrackSample, ...] = ()  # since the answer before, after `start_tracks`
    dropped_samples: int = 0  # further ones that the node could not keep


class Rewind(Message):
    """Undo the simulation ahead of `time`.

    This is possible until the next request that changes something, after the grant with a horizon; later the time
    does not change.
    """

    time: float


class CancelGoal(Message):
    """Cancel a goal: the robot stops, the goal ends as canceled. Unknown and ended goals are NOT_FOUND."""

    id: str


class CancelWatch(Message):
    """Cancel a watch; unknown and fired ones are NOT_FOUND."""

    id: str


class CancelledWatch(Message):
    """End of a cancelled watch.

    `margin` of a watch of a measure is the least distance of the measure to the limit, in its unit.
    """

    margin: float | None = None


EVENTS = Limits(MAX_MESSAGE, 1_000_000)  # 10,000 events at once, or a part of a film

ADVANCE = Verb("advance", Advance, Advanced, reply_limits=EVENTS)
REWIND = Verb("rewind", Rewind, SimulationTime)
CANCEL_GOAL = Verb("cancel_goal", CancelGoal, Empty)
CANCEL_WATCH = Verb("cancel_watch", CancelWatch, CancelledWatch)


def steps_until(time: float, steps_per_second: int) -> int:
    """Return the number of steps from zero to the first that ends at or after a time [s]."""
    steps = math.ceil(time * steps_per_second)
    # The product is rounded, and may be off by one.
    while steps / steps_per_second < time:
        steps += 1
    while (steps - 1) / steps_per_second >= time:
        steps -= 1
    return steps
