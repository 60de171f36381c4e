"""The map of a world, as robots that navigate know it."""

from __future__ import annotations

from seoro.bridges.wire.limits import BYTES
from seoro.bridges.wire.message import Empty, Message, Verb


class OccupancyGrid(Message):
    """What stands fixed, in square cells: 100 where there is something, 0 where there is nothing, a byte for each.

    `x` and `y` [m] are the lower corner, in `map`. Cells go along x first, then along y.
    """

    resolution: float  # [m]
    x: float
    y: float
    columns: int
    rows: int
    cells: bytes


GET_MAP = Verb("get_map", Empty, OccupancyGrid, answers=BYTES)
