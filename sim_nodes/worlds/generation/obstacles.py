"""Fields of obstacles by a cellular automaton."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Pose2
from sim_nodes.physics import Wall
from sim_nodes.worlds.floor_plan import MAX_BOXES, merged
from sim_nodes.worlds.generation.layout import (
    GOAL,
    START,
    Dimensions,
    Layout,
    Mark,
    NoLayout,
    about_origin,
    outer_walls,
    widened,
)
from sim_nodes.worlds.generation.schema import ObstaclesFile

OBSTACLES = "obstacles"  # entity of the filled cells
BORN = 5  # filled neighbours with which a free cell becomes filled

Mask = NDArray[np.bool_]


def obstacles(field: ObstaclesFile, of: Dimensions, random: np.random.Generator) -> Layout:
    """Draw a field between the poses `start`, at lower x, and `goal`.

    Args:
        field: Parameters.
        of: Height and thickness of the walls; obstacles have the same height.
        random: Source of random numbers.

    Raises:
        NoLayout: The field has too many obstacles.
    """
    width, depth = field.size
    rows, columns = (max(1, round(edge / field.cell)) for edge in (depth, width))
    cells = automaton(random.random((rows, columns)) < field.fill, field.smoothing, field.keep)
    boxes = merged(cells)
    if len(boxes) > MAX_BOXES:
        raise NoLayout(f"the obstacles need {len(boxes)} boxes; expected at most {MAX_BOXES}")
    extent = about_origin(width + 2 * field.margin, depth)
    solids = tuple(
        Wall(
            OBSTACLES,
            (left + right - columns) / 2 * field.cell,
            (top + bottom - rows) / 2 * field.cell,
            0.0,
            (right - left) * field.cell,
            (bottom - top) * field.cell,
            of.height,
        )
        for left, top, right, bottom in boxes
    )
    end = (width + field.margin) / 2
    marks = (Mark(START, Pose2(-end, 0.0, 0.0)), Mark(GOAL, Pose2(end, 0.0, 0.0), ("goal",)))
    return Layout(widened(extent, of.thickness), (*outer_walls(extent, of), *solids), marks)


def automaton(cells: Mask, steps: int, keep: int) -> Mask:
    """Smooth filled cells; see `ObstaclesFile`. Cells beyond the border count as free.

    Args:
        cells: Filled cells, shape (rows, columns).
        steps: Number of steps.
        keep: Filled neighbours below which a cell becomes free.
    """
    for _ in range(steps):
        padded = np.pad(cells.astype(np.int64), 1)
        rows, columns = cells.shape
        around = sum(padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)) - cells
        cells = (around >= BORN) | (cells & (around >= keep))
    return cells
