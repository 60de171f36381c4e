"""Generates worlds: draws layouts and clutter until a robot can move between all named poses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seoro.deferred import dataclass
from seoro.files.yaml_lines import FileError
from sim_nodes.extents import outline
from sim_nodes.geometry import Array, quaternion
from sim_nodes.navigation.grid_search import connected_cells
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.noise import Noise
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Part, Wall
from sim_nodes.worlds.generation.layout import Dimensions, Layout, NoLayout
from sim_nodes.worlds.generation.maze import maze
from sim_nodes.worlds.generation.obstacles import obstacles
from sim_nodes.worlds.generation.rooms import rooms
from sim_nodes.worlds.generation.schema import KINDS, ClutterFile, GenerateFile
from sim_nodes.worlds.props import Prop

ATTEMPTS = 50  # draws with one seed
TRIES = 100  # places for one piece of clutter
GAP = 0.02  # [m] minimum distance of clutter from other things
FIXED, LOOSE = "clutter", "loose"  # names of props begin with these


@dataclass(frozen=True)
class Generated:
    """A generated world: its layout and clutter, and the number of the draw."""

    layout: Layout
    props: tuple[Prop, ...]
    attempt: int


def generate(file: GenerateFile, of: Dimensions, walls: Sequence[Wall], seed: int) -> Generated:
    """Generate a world.

    Args:
        file: Parameters.
        of: Height and thickness of the walls.
        walls: Further walls of the world.
        seed: Seed of the run, which applies if the file has none.

    Raises:
        FileError: No draw is passable; the message has the last reason.
    """
    chosen = seed if file.seed is None else file.seed
    reason = ""
    for attempt in range(ATTEMPTS):
        try:
            return _draw(file, of, walls, chosen, attempt)
        except NoLayout as error:
            reason = str(error)
    raise FileError(
        f"generate: no valid world in {ATTEMPTS} draws with the seed {chosen}: {reason}; expected more space, "
        "fewer obstacles, or a smaller `clearance`"
    )


def _draw(file: GenerateFile, of: Dimensions, walls: Sequence[Wall], seed: int, attempt: int) -> Generated:
    random = Noise(seed, "world").at(attempt)
    layout = _layout(file, of, random)
    solids = [*layout.walls, *walls]
    # Walls alone are checked first, since clutter needs places on free floor.
    known = build_map(layout.extent, solids)
    _check_passable(layout, known, file.clearance)
    props = _clutter(file, layout, known, random)
    if props:
        outlines: list[Array] = [outline(part, prop.state) for prop in props for part in prop.model.parts]
        _check_passable(layout, build_map(layout.extent, solids, outlines), file.clearance)
    return Generated(layout, props, attempt)


def _layout(file: GenerateFile, of: Dimensions, random: np.random.Generator) -> Layout:
    if file.rooms is not None:
        return rooms(file.rooms, of, random)
    if file.maze is not None:
        return maze(file.maze, of, random)
    assert file.obstacles is not None, f"the schema requires one of {KINDS}"
    return obstacles(file.obstacles, of, random)


def _check_passable(layout: Layout, known: NavigationMap, clearance: float) -> None:
    """Check that a circle can move between all named poses.

    Raises:
        NoLayout: It cannot; the message names a pose.
    """
    first, *others = layout.marks
    region = connected_cells(known.distance >= clearance, known.grid.cell(first.pose.x, first.pose.y))
    for mark in others:
        if not region[known.grid.cell(mark.pose.x, mark.pose.y)]:
            raise NoLayout(f"no way with {clearance:g} m of clearance from {first.name} to {mark.name}")


def _clutter(
    file: GenerateFile, layout: Layout, known: NavigationMap, random: np.random.Generator
) -> tuple[Prop, ...]:
    placed: list[tuple[float, float, float]] = [
        (mark.pose.x, mark.pose.y, file.clearance) for mark in layout.marks
    ]
    props = []
    numbered = [(FIXED, index) for index in range(1, file.clutter.fixed + 1)]
    numbered += [(LOOSE, index) for index in range(1, file.clutter.loose + 1)]
    for kind, index in numbered:
        prop, radius = _piece(f"{kind}_{index}", file.clutter, random, is_fixed=kind == FIXED)
        x, y = _free_place(placed, known, radius, random)
        placed.append((x, y, radius))
        props.append(replace(prop, state=replace(prop.state, position=(x, y, prop.state.position[2]))))
    return tuple(props)


def _piece(name: str, clutter: ClutterFile, random: np.random.Generator, *, is_fixed: bool) -> tuple[Prop, float]:
    """Return a box or a cylinder on the floor at the origin, and the radius of its outline [m]."""
    width, depth, height = random.uniform(clutter.smallest, clutter.largest, 3).tolist()
    yaw = float(random.uniform(-math.pi, math.pi))
    is_box = bool(random.random() < 0.5)
    shape = Box((width, depth, height)) if is_box else Cylinder(width / 2, height)
    radius = math.hypot(width, depth) / 2 if is_box else width / 2
    model = BodyModel((Part(shape),), 1.0 if is_fixed else clutter.mass, static=is_fixed)
    return Prop(name, model, BodyState((0.0, 0.0, height / 2), quaternion(0.0, 0.0, yaw))), radius


def _free_place(
    placed: Sequence[tuple[float, float, float]],
    known: NavigationMap,
    radius: float,
    random: np.random.Generator,
) -> tuple[float, float]:
    """Return a position for a circle, away from walls and other circles (x, y, radius) [m].

    Raises:
        NoLayout: No free place was found.
    """
    grid = known.grid
    for _ in range(TRIES):
        x = grid.x + float(random.random()) * grid.columns * grid.resolution
        y = grid.y + float(random.random()) * grid.rows * grid.resolution
        from_walls = known.distance[grid.cell(x, y)] - grid.resolution  # of the cell's centre
        if from_walls >= radius and all(
            math.hypot(x - px, y - py) >= radius + other + GAP for px, py, other in placed
        ):
            return round(x, 4), round(y, 4)
    raise NoLayout("no free floor is left for `clutter`")
