"""Schema of `generate` in world files."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from seoro.files.key_rules import KeyCount, KeyRules, WithKeyRules
from sim_nodes.files import Declared

KINDS = ("rooms", "maze", "obstacles")
MAX_CELLS = 10_000  # of a field of obstacles
SEEDS = 2**63

Share = Annotated[float, Field(ge=0.0, le=1.0)]
Width = Annotated[float, Field(ge=0.4, le=10.0)]  # [m]
Span = Annotated[float, Field(ge=2.0, le=100.0)]  # [m]


class RoomsFile(Declared):
    """Rooms with doors, in a rectangle about the origin of `map`.

    With a `corridor`, that is in the middle, along x. Every room can be reached; `loops` is the share of further
    pairs of neighbouring rooms with a door.
    """

    size: tuple[Span, Span] = (12.0, 8.0)  # along x, y [m]
    count: Annotated[int, Field(ge=2, le=40)] = 5  # rooms, besides the corridor
    smallest: Annotated[float, Field(ge=1.2, le=20.0)] = 2.0  # minimum edge of a room [m]
    corridor: Annotated[float, Field(ge=0.8, le=10.0)] | None = None  # width [m]
    door: Width = 0.9  # width [m]
    doors: Literal["open", "closed", "automatic"] = "open"  # `open` has none in the openings
    loops: Share = 0.2


class MazeFile(Declared):
    """A maze of square cells about the origin of `map`; `loops` is the share of inner walls without need."""

    columns: Annotated[int, Field(ge=2, le=30)] = 6
    rows: Annotated[int, Field(ge=2, le=30)] = 5
    cell: Annotated[float, Field(ge=0.6, le=5.0)] = 1.4  # [m]
    loops: Share = 0.0


class ObstaclesFile(Declared):
    """A field of obstacles by a cellular automaton, as in the BARN data set [Perille et al. 2020].

    At first, each cell is filled with the probability `fill`. In each of `smoothing` steps, a cell with five or
    more filled cells around it becomes filled, and one with fewer than `keep` becomes free.
    """

    size: tuple[Span, Span] = (4.5, 4.5)  # of the field along x, y [m]
    cell: Annotated[float, Field(ge=0.05, le=1.0)] = 0.15  # [m]
    fill: Annotated[float, Field(ge=0.0, le=0.6)] = 0.2
    smoothing: Annotated[int, Field(ge=0, le=10)] = 4
    keep: Annotated[int, Field(ge=0, le=4)] = 2
    margin: Annotated[float, Field(ge=0.6, le=10.0)] = 1.2  # free floor before and behind the field, along x [m]

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        cells = self.size[0] * self.size[1] / self.cell**2
        if cells > MAX_CELLS:
            raise ValueError(f"found {cells:.0f} cells in the field; expected at most {MAX_CELLS}")
        return self


class ClutterFile(Declared):
    """Boxes and cylinders on free floor: `fixed` ones in maps of robots, `loose` ones that can be pushed."""

    fixed: Annotated[int, Field(ge=0, le=40)] = 0
    loose: Annotated[int, Field(ge=0, le=40)] = 0
    smallest: Annotated[float, Field(ge=0.05, le=2.0)] = 0.2  # width [m]
    largest: Annotated[float, Field(ge=0.05, le=2.0)] = 0.5  # width [m]
    mass: Annotated[float, Field(ge=0.01, le=1000.0)] = 2.0  # of loose ones [kg]

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.smallest > self.largest:
            raise ValueError("expected `smallest` of `clutter` up to `largest`")
        return self


class GenerateFile(Declared, WithKeyRules):
    """A generated world of one kind. The same parameters and seed give the same world.

    A circle with the radius `clearance` can move between all named poses.
    """

    rooms: RoomsFile | None = None
    maze: MazeFile | None = None
    obstacles: ObstaclesFile | None = None
    clutter: ClutterFile = ClutterFile()
    clearance: Annotated[float, Field(ge=0.05, le=2.0)] = 0.3  # [m]
    seed: Annotated[int, Field(ge=0, lt=SEEDS)] | None = None  # None for that of the run

    key_rules: ClassVar[KeyRules] = (
        KeyCount(KINDS, (1,), f"expected one of {', '.join(KINDS)}, found {{found}}"),
    )
