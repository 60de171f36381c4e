"""Doors and lifts of the world: goals, locks and watches."""

from __future__ import annotations

from seoro.bridges.wire.message import Empty, Message, TrackedRequest, Verb


class MoveDoor(TrackedRequest):
    """Move a door; the end is reported as the `Occurrence` with this `id`.

    A door stops before an obstacle, and tries again. Without progress, the goal is aborted. The request is
    refused while another goal is active, or if the door is locked.

    Attributes:
        door: Name of a door.
        opening: Opening to reach: 0 is closed, 1 open.
    """

    door: str
    opening: float


class LockDoor(Message):
    """Lock a closed door, or unlock it. A locked door stays closed.

    Attributes:
        door: Name of a door.
        locked: Whether to lock it.
    """

    door: str
    locked: bool = True


class WatchDoor(TrackedRequest):
    """Report when the opening of a door is in a range, which may be at once.

    Attributes:
        door: Name of a door.
        least: Lower end of the range; 0 is closed.
        most: Upper end; 1 is open.
    """

    door: str
    least: float = 0.0
    most: float = 1.0


class MoveLift(TrackedRequest):
    """Move a lift to a floor; the end is reported as the `Occurrence` with this `id`.

    A lift that sinks stops above an obstacle.

    Attributes:
        lift: Name of a lift.
        floor: Number of the floor, from 0.
    """

    lift: str
    floor: int


class WatchLift(TrackedRequest):
    """Report when a lift is at a floor, which may be at once.

    Attributes:
        lift: Name of a lift.
        floor: Number of the floor, from 0.
    """

    lift: str
    floor: int


MOVE_DOOR = Verb("move_door", MoveDoor, Empty)
LOCK_DOOR = Verb("lock_door", LockDoor, Empty)
WATCH_DOOR = Verb("watch_door", WatchDoor, Empty)
MOVE_LIFT = Verb("move_lift", MoveLift, Empty)
WATCH_LIFT = Verb("watch_lift", WatchLift, Empty)
