"""People and carts of the world: spawning people, and goals of both. `person` may also name a cart."""

from __future__ import annotations

from seoro.bridges.wire.entities import EntityName
from seoro.bridges.wire.message import Empty, Message, TrackedRequest, Verb
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.robotics.people import Avoidance


class SpawnPerson(Message):
    """Spawn a standing person on the floor; the height of the pose is ignored.

    Attributes:
        name: Name of the entity.
        pose: Its pose.
        speed: Its usual speed [m/s].
        radius: Its radius [m].
        height: Its height [m].
        avoid: Its way to avoid others.
    """

    name: str
    pose: Pose3D
    speed: float = 1.3
    radius: float = 0.25
    height: float = 1.7
    avoid: Avoidance = Avoidance.SOCIAL_FORCE


class WalkAlong(TrackedRequest):
    """Walk along straight lines between points; the end is reported as the `Occurrence` with this `id`.

    The goal is aborted after a time without progress, and refused while another one is active.

    Attributes:
        person: Name of a person or cart.
        points: Points of the path; z is ignored.
        place: Named pose as the last point; empty for none.
        speed: [m/s]; 0 for the person's own.
        repeat: Whether to start again at the first point, without an end.
    """

    person: str
    points: tuple[Position3D, ...] = ()
    place: str = ""
    speed: float = 0.0
    repeat: bool = False


class Wander(TrackedRequest):
    """Walk between random points of an area, without an end.

    Attributes:
        person: Name of a person or cart.
        lower: Lower corner; z is ignored.
        upper: Upper corner.
        speed: [m/s]; 0 for the person's own.
    """

    person: str
    lower: Position3D
    upper: Position3D
    speed: float = 0.0


class WalkAfter(TrackedRequest):
    """Follow an entity in straight lines, without an end.

    Attributes:
        person: Name of a person or cart.
        entity: Robot, body or person to follow.
        distance: Distance to keep [m].
        speed: Maximum speed [m/s]; 0 for the person's own.
    """

    person: str
    entity: str
    distance: float
    speed: float = 0.0


class PersonName(Message):
    """A person or cart by name."""

    person: str


SPAWN_PERSON = Verb("spawn_person", SpawnPerson, EntityName)
WALK_ALONG = Verb("walk_along", WalkAlong, Empty)
WANDER = Verb("wander", Wander, Empty)
WALK_AFTER = Verb("walk_after", WalkAfter, Empty)
STAND_STILL = Verb("stand_still", PersonName, Empty)
