"""Schema of the ground in world files."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from sim_nodes.files import Declared
from sim_nodes.models.xml_reading import FRICTIONS
from sim_nodes.terrain.ground import FLOOR_FRICTION
from sim_nodes.worlds.fields import Length, Point

MAX_HEIGHT = 10.0  # [m]
MAX_PIECES = 100
MAX_POINTS = 40_000  # of a height field
FORMS = ("ramp", "platform", "steps", "heightfield", "rough")


def _not_below_the_floor(rise: float) -> float:
    """Refuse pits and ramps down.

    Raises:
        ValueError: The rise is negative.
    """
    if rise < 0.0:
        raise ValueError(
            f"unsupported terrain below the floor ({rise:g}): the floor is a plane without holes; expected "
            "0 or more, or platforms and ramps around a pit"
        )
    return rise


Rise = Annotated[float, AfterValidator(_not_below_the_floor)]
Friction = Annotated[float, Field(ge=FRICTIONS[0], le=FRICTIONS[1])]
Height = Annotated[Rise, Field(gt=0.0, le=MAX_HEIGHT)]  # [m]


class FloorFile(Declared):
    """The floor, and its coefficient of sliding friction."""

    friction: Friction = FLOOR_FRICTION


class RampFile(Declared):
    """A ramp: its length and width, and its heights at both ends [m] or its angle [rad]."""

    size: tuple[Length, Length]
    heights: tuple[Rise, Rise] | None = None  # at the begin and the end
    angle: Annotated[Rise, Field(gt=0.0, le=1.2)] | None = None  # from the floor

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if (self.heights is None) == (self.angle is None):
            raise ValueError("expected either `heights` or `angle` of a ramp")
        low, high = self.ends
        if not 0.0 < max(low, high) <= MAX_HEIGHT:
            raise ValueError(f"invalid heights {low:g} and {high:g} of a ramp; expected 0 to {MAX_HEIGHT:g} m")
        return self

    @property
    def ends(self) -> tuple[float, float]:
        """Heights at both ends [m]."""
        if self.heights is not None:
            return self.heights
        assert self.angle is not None, "checked"
        return 0.0, self.size[0] * math.tan(self.angle)


class PlatformFile(Declared):
    """A level block: its length, width and height [m]."""

    size: tuple[Length, Length]
    height: Height


class StepsFile(Declared):
    """Steps that rise along their length, from the floor [m]."""

    count: Annotated[int, Field(ge=1, le=50)]
    rise: Height
    run: Length
    width: Length

    @model_validator(mode="after")
    def _not_too_high(self) -> Self:
        if self.count * self.rise > MAX_HEIGHT:
            raise ValueError(f"the steps are {self.count * self.rise:g} m high; expected at most {MAX_HEIGHT:g} m")
        return self


class HeightFieldFile(Declared):
    """Heights by the grey of a picture: black is the floor, white is `height` [m]. Its edges are on the floor."""

    image: str  # PNG, PGM or JPEG, relative to the folder of the file
    size: tuple[Length, Length]  # along the rows and the columns of the picture
    height: Height


class RoughFile(Declared):
    """Random bumps, on the floor at the edges [m]; `seed` replaces that of the run."""

    size: tuple[Length, Length]
    height: Height  # of the highest possible bump
    spacing: Annotated[float, Field(ge=0.05, le=10.0)] = 0.2  # of bumps
    seed: Annotated[int, Field(ge=0)] | None = None

    @model_validator(mode="after")
    def _has_bumps(self) -> Self:
        columns, rows = self.points
        if columns * rows > MAX_POINTS:
            raise ValueError(f"{columns} by {rows} bumps; expected at most {MAX_POINTS}: increase `spacing`")
        return self

    @property
    def points(self) -> tuple[int, int]:
        """Number of points along the length and the width, at least 3."""
        length, width = (max(3, round(edge / self.spacing) + 1) for edge in self.size)
        return length, width


class TerrainFile(Declared):
    """A piece of terrain, which raises the floor around its centre; its length is along `yaw`."""

    ramp: RampFile | None = None
    platform: PlatformFile | None = None
    steps: StepsFile | None = None
    heightfield: HeightFieldFile | None = None
    rough: RoughFile | None = None
    center: Point = (0.0, 0.0)
    yaw: float = 0.0
    friction: Friction | None = None  # that of the floor by default

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        forms = [form for form in FORMS if getattr(self, form) is not None]
        if len(forms) != 1:
            raise ValueError(
                f"expected one of {', '.join(FORMS)} in a piece of terrain, found {' and '.join(forms) or 'none'}"
            )
        return self
