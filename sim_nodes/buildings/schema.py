"""Schema of the doors and lifts of world files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from sim_nodes.agents.schema import FloorPoseFile
from sim_nodes.files import Declared
from sim_nodes.worlds.fields import Edge, Name, Share, Tags

MAX_PARTS = 50  # doors and lifts of a world
MAX_FLOORS = 20
MIN_STOREY = 0.05  # [m] between two floors of a lift
LEAST_ANGLE, MOST_ANGLE = 0.2, 3.0  # [rad] of a hinged door

Speed = Annotated[float, Field(ge=0.05, le=2.0)]  # [m/s]
Height = Annotated[float, Field(ge=0.0, le=15.0)]  # [m]
Colour = tuple[Share, Share, Share]


class AutomaticFile(Declared):
    """A door that opens by itself while a robot, a person or a cart is near its middle."""

    range: Annotated[float, Field(ge=0.3, le=10.0)] = 1.5  # [m]
    hold: Annotated[float, Field(ge=0.0, le=60.0)] = 2.0  # [s] that it stays open afterwards


class DoorFile(Declared):
    """A door in an opening, whose middle is at `pose`; x of the pose leads through it, y to its left side.

    Two leaves open to both sides, and are the entities `NAME_left` and `NAME_right`. A single one has the name of
    the door.
    """

    name: Annotated[Name, Field(max_length=58)]
    pose: FloorPoseFile = FloorPoseFile()
    z: Height | None = None  # of the floor below it [m]; that of the ground by default
    kind: Literal["hinged", "sliding"] = "hinged"
    leaves: Literal[1, 2] = 1
    side: Literal["left", "right"] | None = None  # of the hinge, or to which one leaf slides; left by default
    width: Annotated[float, Field(ge=0.4, le=10.0)] = 0.9  # of the opening [m]
    height: Edge | None = None  # [m]; that of walls by default
    thickness: Annotated[float, Field(ge=0.01, le=0.5)] = 0.04  # [m]
    angle: Annotated[float, Field(ge=-MOST_ANGLE, le=MOST_ANGLE)] | None = None  # [rad] of hinged leaves
    way: Annotated[float, Field(ge=0.1, le=10.0)] | None = None  # [m] of sliding leaves
    speed: Speed = 0.5  # of the outer edge of a leaf [m/s]
    force: Annotated[float, Field(ge=10.0, le=2000.0)] | None = None  # limit of a leaf against obstacles [N]
    opening: Share = 0.0  # at the start: 0 closed, 1 open
    locked: bool = False
    automatic: AutomaticFile | None = None
    colour: Colour | None = None  # red, green, blue, from 0 to 1
    tags: Tags = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.kind == "sliding" and self.angle is not None:
            raise ValueError("unexpected `angle` of a sliding door; expected `way` [m], or nothing")
        if self.kind == "hinged" and self.way is not None:
            raise ValueError("unexpected `way` of a hinged door; expected `angle` [rad], or nothing")
        if self.angle is not None and abs(self.angle) < LEAST_ANGLE:
            raise ValueError(
                f"invalid `angle` {self.angle:g}; expected {LEAST_ANGLE:g} rad or more, or the negative"
            )
        if self.leaves == 2 and self.side is not None:
            raise ValueError("unexpected `side`: a door with two leaves opens to both sides")
        if self.locked and self.opening > 0.0:
            raise ValueError("unexpected `opening` of a locked door; expected 0")
        return self

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of its leaves."""
        return (self.name,) if self.leaves == 1 else (f"{self.name}_left", f"{self.name}_right")


class LiftFile(Declared):
    """A lift: a platform that stops at floors, with its middle at `pose`; `start` is its first floor, from 0."""

    name: Name
    pose: FloorPoseFile = FloorPoseFile()
    size: tuple[Edge, Edge] = (1.5, 1.5)  # length and width of the platform [m]
    thickness: Annotated[float, Field(ge=0.02, le=0.5)] = 0.1  # [m]
    # Heights above the ground under its middle, upwards [m].
    floors: Annotated[tuple[Height, ...], Field(min_length=2, max_length=MAX_FLOORS)]
    speed: Speed = 0.3  # [m/s]
    start: Annotated[int, Field(ge=0, lt=MAX_FLOORS)] = 0
    colour: Colour | None = None  # red, green, blue, from 0 to 1
    tags: Tags = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if any(upper - lower < MIN_STOREY for lower, upper in pairwise(self.floors)):
            raise ValueError(f"invalid `floors`; expected ascending heights, {MIN_STOREY:g} m or more apart")
        if self.start >= len(self.floors):
            raise ValueError(f"unknown floor {self.start} in `start`; expected 0 to {len(self.floors) - 1}")
        return self


def building_names(doors: Sequence[DoorFile], lifts: Sequence[LiftFile]) -> Iterable[tuple[str, str]]:
    """Yield kind and name of the doors with their leaves, and of the lifts.

    Raises:
        ValueError: There are too many.
    """
    if (count := len(doors) + len(lifts)) > MAX_PARTS:
        raise ValueError(f"found {count} doors and lifts; expected at most {MAX_PARTS}")
    yield from (("door", name) for door in doors for name in {door.name: None, **dict.fromkeys(door.bodies)})
    yield from (("lift", lift.name) for lift in lifts)
