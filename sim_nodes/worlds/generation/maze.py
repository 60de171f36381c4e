"""Mazes: a spanning tree of cells by a random walk that turns back (recursive backtracking)."""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Pose2
from sim_nodes.physics import Wall
from sim_nodes.worlds.generation.layout import (
    GOAL,
    START,
    Dimensions,
    Layout,
    Mark,
    about_origin,
    outer_walls,
    segment,
    widened,
)
from sim_nodes.worlds.generation.schema import MazeFile

Cell = tuple[int, int]  # column, row
Side = tuple[Cell, Cell]  # two neighbours, the lower one first


def maze(maze: MazeFile, of: Dimensions, random: np.random.Generator) -> Layout:
    """Draw a maze with the poses `start`, in its lower left cell, and `goal`, in its upper right one.

    Args:
        maze: Parameters.
        of: Height and thickness of the walls.
        random: Source of random numbers.
    """
    extent = about_origin(maze.columns * maze.cell, maze.rows * maze.cell)
    open_sides = _tree(maze, random)
    closed = [side for side in _sides(maze) if side not in open_sides]
    chosen = random.permutation(len(closed))[: round(maze.loops * len(closed))].tolist()
    open_sides |= {closed[index] for index in chosen}
    walls = (*outer_walls(extent, of), *_inner(maze, open_sides, of))
    last = (maze.columns - 1, maze.rows - 1)
    marks = (
        Mark(START, _centre(maze, (0, 0), _first_yaw(open_sides))),
        Mark(GOAL, _centre(maze, last, 0.0), ("goal",)),
    )
    return Layout(widened(extent, of.thickness), walls, marks)


def _sides(maze: MazeFile) -> list[Side]:
    across = [((i, j), (i + 1, j)) for i in range(maze.columns - 1) for j in range(maze.rows)]
    along = [((i, j), (i, j + 1)) for i in range(maze.columns) for j in range(maze.rows - 1)]
    return across + along


def _tree(maze: MazeFile, random: np.random.Generator) -> set[Side]:
    """Return the open sides of a random spanning tree."""
    path: list[Cell] = [(0, 0)]
    seen, open_sides = set(path), set()
    while path:
        here = path[-1]
        fresh = [cell for cell in _neighbours(maze, here) if cell not in seen]
        if not fresh:
            path.pop()
            continue
        cell = fresh[int(random.integers(len(fresh)))]
        open_sides.add((min(here, cell), max(here, cell)))
        seen.add(cell)
        path.append(cell)
    return open_sides


def _neighbours(maze: MazeFile, cell: Cell) -> list[Cell]:
    i, j = cell
    around = ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
    return [(x, y) for x, y in around if 0 <= x < maze.columns and 0 <= y < maze.rows]


def _inner(maze: MazeFile, open_sides: set[Side], of: Dimensions) -> list[Wall]:
    """Return the inner walls, neighbouring ones in a row as one."""
    left, bottom = -maze.columns * maze.cell / 2, -maze.rows * maze.cell / 2
    walls = []
    for i in range(maze.columns - 1):
        x = left + (i + 1) * maze.cell
        for first, last in _runs([((i, j), (i + 1, j)) not in open_sides for j in range(maze.rows)]):
            walls.append(segment((x, bottom + first * maze.cell), (x, bottom + last * maze.cell), of))
    for j in range(maze.rows - 1):
        y = bottom + (j + 1) * maze.cell
        for first, last in _runs([((i, j), (i, j + 1)) not in open_sides for i in range(maze.columns)]):
            walls.append(segment((left + first * maze.cell, y), (left + last * maze.cell, y), of))
    return walls


def _runs(closed: list[bool]) -> list[tuple[int, int]]:
    """Return the first index of each run of true values, and the one after its last."""
    steps = np.diff(np.array([False, *closed, False], dtype=np.int8))
    return list(zip(np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True))


def _centre(maze: MazeFile, cell: Cell, yaw: float) -> Pose2:
    x = (cell[0] + 0.5 - maze.columns / 2) * maze.cell
    y = (cell[1] + 0.5 - maze.rows / 2) * maze.cell
    return Pose2(x, y, yaw)


def _first_yaw(open_sides: set[Side]) -> float:
    """Return the yaw at the start along which the maze is open [rad]."""
    return 0.0 if ((0, 0), (1, 0)) in open_sides else math.pi / 2
