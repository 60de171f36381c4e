"""Types of the fields of world files."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from sim_nodes.files import NAME
from sim_nodes.models.xml_reading import SIZES

MAX_TAGS = 20
TAG = r"^[^\s,]{1,64}$"

Name = Annotated[str, Field(pattern=NAME)]
Coordinate = Annotated[float, Field(ge=-100.0, le=100.0)]  # [m]
Length = Annotated[float, Field(gt=0.0, le=200.0)]  # [m]
Edge = Annotated[float, Field(ge=SIZES[0], le=SIZES[1])]  # [m]
Tag = Annotated[str, Field(pattern=TAG)]
Tags = Annotated[tuple[Tag, ...], Field(max_length=MAX_TAGS)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Point = tuple[Coordinate, Coordinate]
