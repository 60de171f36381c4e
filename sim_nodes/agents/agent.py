"""People and carts: their bodies, traits and motions."""

from __future__ import annotations

from seoro.bridges.wire import Avoidance
from seoro.deferred import dataclass
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.physics import BodyModel, BodyState, Box, Capsule, Part
from sim_nodes.views import Colour

HOVER = 0.01  # [m] between a body and the floor, which it must not touch
MASS = 75.0  # [kg] of a person
LEG_RADIUS, LEG_OFFSET, LEGS = 0.07, 0.1, 0.45  # [m], [m], share of the height
WAIST = 0.4  # share of the height at which the trunk begins
FRICTION = 0.5

Point = tuple[float, float]  # [m]


@dataclass(frozen=True)
class Stand:
    """Stay at a place."""


@dataclass(frozen=True)
class Walk:
    """Walk along straight lines between points [m].

    Attributes:
        points: Points of the path.
        speed: [m/s]
        repeat: Whether to start again at the first point.
        index: Index of the next point.
    """

    points: tuple[Point, ...]
    speed: float
    repeat: bool = False
    index: int = 0


@dataclass(frozen=True)
class Wander:
    """Walk to random points of an area (lower x, lower y, upper x, upper y) [m]; `target` is the present one."""

    area: tuple[float, float, float, float]
    speed: float
    target: Point | None = None


@dataclass(frozen=True)
class Follow:
    """Follow an entity at a distance [m]."""

    entity: str
    distance: float
    speed: float


Motion = Stand | Walk | Wander | Follow


@dataclass(frozen=True)
class Agent:
    """A person or a cart.

    Attributes:
        model: Its body.
        pose: Its initial pose [m, rad].
        speed: Its usual speed [m/s].
        radius: Radius of the circle that it keeps free [m].
        avoid: Its way to avoid others.
        motion: Its initial motion.
        is_person: Whether it is a person.
        tags: Tags of the entity.
    """

    model: BodyModel
    pose: Pose2
    speed: float
    radius: float
    avoid: Avoidance = Avoidance.SOCIAL_FORCE
    motion: Motion = Stand()
    is_person: bool = True
    tags: tuple[str, ...] = ()

    @property
    def state(self) -> BodyState:
        """Initial state of its body."""
        return BodyState((self.pose.x, self.pose.y, HOVER), quaternion(0.0, 0.0, self.pose.yaw))


def person_model(radius: float, height: float, colour: Colour | None = None) -> BodyModel:
    """Return the body of a person: two legs, which lidars near the floor see, and a trunk with the head.

    Args:
        radius: Radius of the trunk [m].
        height: Height of the person [m].
        colour: Colour in pictures.
    """
    legs = (_capsule(LEG_RADIUS, 0.0, LEGS * height, side * LEG_OFFSET) for side in (-1.0, 1.0))
    trunk = _capsule(min(radius, (1.0 - WAIST) * height / 2.1), WAIST * height, height, 0.0)
    return BodyModel((*legs, trunk), MASS, FRICTION, driven=True, colour=colour)


def _capsule(radius: float, low: float, high: float, y: float) -> Part:
    """Return an upright capsule between two heights [m]."""
    return Part(Capsule(radius, high - low - 2.0 * radius), (0.0, y, (low + high) / 2.0))


def cart_model(size: tuple[float, float, float], mass: float, colour: Colour | None = None) -> BodyModel:
    """Return the body of a cart by its edges [m] and its mass [kg]."""
    return BodyModel((Part(Box(size), (0.0, 0.0, size[2] / 2.0)),), mass, FRICTION, driven=True, colour=colour)
