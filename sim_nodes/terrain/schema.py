"""Schema of the ground in world files."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from sim_nodes.files import Declared
from sim_nodes.models.xml_reading import FRICTIONS
from sim_nodes.terrain.ground import FLOOR_FRICTION

Friction = Annotated[float, Field(ge=FRICTIONS[0], le=FRICTIONS[1])]


class FloorFile(Declared):
    """The floor, and its coefficient of sliding friction."""

    friction: Friction = FLOOR_FRICTION
