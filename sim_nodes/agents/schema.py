"""Schema of the people, crowds and carts of world files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from seoro.files.key_rules import KeyCount, KeyRules, WithKeyRules
from sim_nodes.files import Declared
from sim_nodes.worlds.fields import Coordinate, Edge, Name, Point, Share, Tags

MAX_AGENTS = 100  # people and carts of a world
MAX_POINTS = 100  # of a path
SPEEDS = (0.05, 5.0)  # [m/s]
RADII = (0.15, 0.5)  # [m]
HEIGHTS = (1.0, 2.2)  # [m]

Speed = Annotated[float, Field(ge=SPEEDS[0], le=SPEEDS[1])]
Radius = Annotated[float, Field(ge=RADII[0], le=RADII[1])]
Area = tuple[Coordinate, Coordinate, Coordinate, Coordinate]  # lower x, lower y, upper x, upper y
Colour = tuple[Share, Share, Share]


class FloorPoseFile(Declared):
    """Initial pose on the floor [m, rad]."""

    x: Coordinate = 0.0
    y: Coordinate = 0.0
    yaw: float = 0.0


class PathFile(Declared):
    """A path along straight lines between points; with `repeat`, it starts again at the first point."""

    points: Annotated[tuple[Point, ...], Field(min_length=1, max_length=MAX_POINTS)]
    repeat: bool = False


class TraitsFile(Declared, WithKeyRules):
    """Traits and motion of a person. A range is drawn from by the seed."""

    key_rules: ClassVar[KeyRules] = (KeyCount(("walk", "wander"), (0, 1), "expected either `walk` or `wander`"),)

    speed: Speed | tuple[Speed, Speed] = 1.3  # [m/s]
    radius: Radius | tuple[Radius, Radius] = 0.25  # [m]
    height: Annotated[float, Field(ge=HEIGHTS[0], le=HEIGHTS[1])] = 1.7  # [m]
    avoid: Literal["none", "social_force", "orca"] = "social_force"
    walk: PathFile | None = None
    wander: Area | None = None  # area with random destinations
    colour: Colour | None = None  # red, green, blue, from 0 to 1
    tags: Tags = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for name, value in (("speed", self.speed), ("radius", self.radius)):
            if isinstance(value, tuple) and value[0] > value[1]:
                raise ValueError(f"invalid range of `{name}`; expected the lower value first")
        if self.wander is not None:
            check_area(self.wander, "wander")
        return self


class PersonFile(TraitsFile):
    """A person; without `walk` and `wander`, one that stands."""

    name: Name
    pose: FloorPoseFile = FloorPoseFile()


class CrowdFile(TraitsFile):
    """People at random places in an area; their names are that of the crowd with a number, from 1."""

    name: Annotated[Name, Field(max_length=60)]
    count: Annotated[int, Field(ge=1, le=MAX_AGENTS)]
    area: Area

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_area(self.area, "area")
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its people."""
        return tuple(f"{self.name}_{number}" for number in range(1, self.count + 1))


class CartFile(Declared):
    """A cart: a box that moves along a path, and stops at contacts."""

    name: Name
    size: tuple[Edge, Edge, Edge]  # length, width, height [m]
    mass: Annotated[float, Field(ge=1.0, le=2000.0)] = 50.0  # [kg]
    pose: FloorPoseFile = FloorPoseFile()
    speed: Speed = 0.5  # [m/s]
    path: PathFile | None = None
    colour: Colour | None = None
    tags: Tags = ()


AgentFile = PersonFile | CrowdFile | CartFile


def check_area(area: Area, key: str) -> None:
    """Check that the lower corner of an area comes first.

    Raises:
        ValueError: It does not.
    """
    left, bottom, right, top = area
    if not (left < right and bottom < top):
        raise ValueError(f"invalid `{key}`; expected [lower x, lower y, upper x, upper y]")


def agent_names(
    people: Sequence[PersonFile], crowds: Sequence[CrowdFile], carts: Sequence[CartFile]
) -> Iterable[tuple[str, str]]:
    """Yield kind and name of all agents of a world.

    Raises:
        ValueError: There are too many.
    """
    count = len(people) + len(carts) + sum(crowd.count for crowd in crowds)
    if count > MAX_AGENTS:
        raise ValueError(f"found {count} people and carts; expected at most {MAX_AGENTS}")
    yield from (("person", person.name) for person in people)
    yield from (("person", name) for crowd in crowds for name in crowd.names)
    yield from (("cart", cart.name) for cart in carts)
