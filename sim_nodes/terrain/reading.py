"""The ground of a world, from its file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from seoro.files.yaml_lines import FileError
from sim_nodes.geometry import Array, Pose2
from sim_nodes.noise import Noise
from sim_nodes.terrain.ground import Ground, HeightField, Slab
from sim_nodes.terrain.schema import MAX_POINTS, FloorFile, HeightFieldFile, RoughFile, StepsFile, TerrainFile

Extent = tuple[float, float, float, float]


def read_ground(
    floor: FloorFile, terrain: Sequence[TerrainFile], folder: Path, seed: int, extent: Extent
) -> Ground:
    """Read the floor and the terrain of a world file.

    Args:
        floor: The floor.
        terrain: The pieces of terrain.
        folder: Folder that relative file names start from.
        seed: Seed of the run, for random terrain.
        extent: Lower x, lower y, upper x, upper y of the map [m].

    Raises:
        FileError: A picture is missing or invalid, or a piece of terrain is outside of the world.
    """
    slabs: list[Slab] = []
    fields: list[HeightField] = []
    left, bottom, right, top = extent
    for index, piece in enumerate(terrain):
        x, y = piece.center
        if not (left <= x <= right and bottom <= y <= top):
            raise FileError(
                f"terrain.{index}.center: ({x:g}, {y:g}) is outside of the world; expected a point from "
                f"({left:g}, {bottom:g}) to ({right:g}, {top:g})"
            )
        slabs += _slabs(piece)
        try:
            fields += _fields(piece, folder, Noise(seed, f"terrain/{index}"), index)
        except FileError as error:
            raise FileError(f"terrain.{index}: {error}") from error
    return Ground(floor.friction, tuple(slabs), tuple(fields))


def _slabs(piece: TerrainFile) -> Iterator[Slab]:
    """Yield the solids of a piece: ramp, platform or steps."""
    place = Pose2(*piece.center, piece.yaw)
    if piece.ramp is not None:
        yield Slab(place, *piece.ramp.size, *piece.ramp.ends, piece.friction)
    elif piece.platform is not None:
        yield Slab(place, *piece.platform.size, piece.platform.height, piece.platform.height, piece.friction)
    elif piece.steps is not None:
        yield from _steps(piece.steps, place, piece.friction)


def _steps(steps: StepsFile, place: Pose2, friction: float | None) -> Iterator[Slab]:
    for number in range(steps.count):
        along = (number + 0.5 - steps.count / 2) * steps.run
        height = (number + 1) * steps.rise
        yield Slab(place.compose(Pose2(along, 0.0, 0.0)), steps.run, steps.width, height, height, friction)


def _fields(piece: TerrainFile, folder: Path, noise: Noise, index: int) -> Iterator[HeightField]:
    """Yield the height field of a piece, if it is one."""
    if piece.heightfield is not None:
        size, shares = piece.heightfield.size, _picture(piece.heightfield, folder)
        grid = piece.heightfield.height * shares
    elif piece.rough is not None:
        size, grid = piece.rough.size, _bumps(piece.rough, noise, index)
    else:
        return
    grid[[0, -1]], grid[:, [0, -1]] = 0.0, 0.0
    if not grid.any():
        raise FileError("the picture is black; expected light pixels within its edges, which are on the floor")
    rows, columns = grid.shape
    data = np.ascontiguousarray(grid, dtype="<f8").tobytes()
    yield HeightField(Pose2(*piece.center, piece.yaw), *size, columns, rows, data, piece.friction)


def _picture(field: HeightFieldFile, folder: Path) -> Array:
    """Return the lightness of a picture, from 0 to 1, the bottom row first."""
    from sim_nodes.worlds.pictures import read_darkness  # noqa: PLC0415 - for worlds with pictures

    darkness = read_darkness(folder / field.image, "heights", MAX_POINTS)
    if min(darkness.shape) < 3:
        raise FileError(f"{field.image} has {darkness.shape[1]} by {darkness.shape[0]} pixels; expected 3 or more")
    lightness: Array = 1.0 - darkness[::-1]
    return lightness


def _bumps(rough: RoughFile, noise: Noise, index: int) -> Array:
    chosen = noise if rough.seed is None else Noise(rough.seed, f"terrain/{index}")
    columns, rows = rough.points
    bumps: Array = rough.height * chosen.at(0).random((rows, columns))
    return bumps
