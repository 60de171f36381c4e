"""Light of world files, for rendered pictures."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from sim_nodes.files import Declared
from sim_nodes.views import DAYLIGHT, Light

SHALLOWEST = math.sin(math.radians(5.0))  # of the sun above the horizon

Factor = Annotated[float, Field(ge=0.0, le=3.0)]


class DirectionFile(Declared):
    """Direction of rays in the map, of any length; z is negative."""

    x: float = DAYLIGHT.direction[0]
    y: float = DAYLIGHT.direction[1]
    z: float = DAYLIGHT.direction[2]

    @model_validator(mode="after")
    def _from_above(self) -> Self:
        length = math.hypot(self.x, self.y, self.z)
        if not 1e-3 < length < 1e3 or -self.z < SHALLOWEST * length:
            raise ValueError(
                f"invalid direction ({self.x:g}, {self.y:g}, {self.z:g}) of light; expected rays at least "
                "5 degrees downwards, such as (0.35, 0.5, -1)"
            )
        return self


class LightFile(Declared):
    """Light in rendered pictures; factors are relative to the usual light."""

    direction: DirectionFile = DirectionFile()  # of the sun
    ambient: Factor = 1.0  # light from all sides
    diffuse: Factor = 1.0  # light of the sun
    brightness: Factor = 1.0  # of both

    @property
    def light(self) -> Light:
        """The light."""
        of = self.direction
        return Light((of.x, of.y, of.z), self.ambient, self.diffuse, self.brightness)
