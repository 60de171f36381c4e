"""Walls, extent and fixed things of a world, from all parts of its file that describe them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from seoro.deferred import dataclass
from seoro.files.yaml_lines import FileError
from sim_nodes.buildings.schema import DoorFile
from sim_nodes.extents import highest_of, lowest_of, outline
from sim_nodes.geometry import Array, quaternion
from sim_nodes.physics import BodyState, Wall
from sim_nodes.terrain.ground import FLAT, Ground
from sim_nodes.worlds.poses import NamedPose
from sim_nodes.worlds.props import Prop
from sim_nodes.worlds.schema import WallFile, WorldFile

OVERHEAD = 0.5  # [m] above the floor; anything that starts higher is above robots and lidar beams
FLUSH = 0.01  # [m] above the floor; anything that ends lower is floor, too

Extent = tuple[float, float, float, float]


@dataclass(frozen=True)
class Surroundings:
    """Walls, extent, props, poses and doors, and warnings about ignored parts of files."""

    extent: Extent
    walls: tuple[Wall, ...]
    props: tuple[Prop, ...] = ()
    poses: tuple[NamedPose, ...] = ()
    warnings: tuple[str, ...] = ()
    doors: tuple[DoorFile, ...] = ()


def read_surroundings(file: WorldFile, folder: Path, seed: int) -> Surroundings:
    """Read what surrounds the robots of a world; `props` and `poses` of the file are added later.

    Args:
        file: The world file.
        folder: Folder that relative file names start from.
        seed: Seed of the run, for generated worlds.

    Raises:
        FileError: A file is missing or invalid, or no generated world is passable.
    """
    walls = tuple(part for wall in file.walls for part in _standing(wall, file))
    if file.generate is not None:
        return _generated(file, walls, seed)
    warnings: tuple[str, ...] = ()
    props: tuple[Prop, ...] = ()
    extent = file.extent
    if file.floor_plan is not None:
        from sim_nodes.worlds.floor_plan import load_floor_plan  # noqa: PLC0415 - pictures, for worlds with one

        planned, covered, warnings = load_floor_plan(file.floor_plan, folder, file.wall_height)
        walls, extent = (*planned, *walls), extent or covered
    if file.scene is not None:
        from sim_nodes.worlds.scenes import read_scene  # noqa: PLC0415 - model files, for worlds with a scene

        scene = read_scene(file.scene, folder)
        props, extent = scene.props, extent or scene.extent
    assert extent is not None, "the schema requires one of them"
    return Surroundings(extent, walls, props, (), warnings)


def _generated(file: WorldFile, walls: tuple[Wall, ...], seed: int) -> Surroundings:
    from sim_nodes.worlds.generation.generate import generate  # noqa: PLC0415 - for such worlds only
    from sim_nodes.worlds.generation.layout import Dimensions  # noqa: PLC0415

    assert file.generate is not None
    found = generate(file.generate, Dimensions(file.wall_height, file.wall_thickness), walls, seed)
    poses = tuple(
        NamedPose(
            mark.name,
            "",
            mark.tags,
            BodyState((mark.pose.x, mark.pose.y, 0.0), quaternion(0.0, 0.0, mark.pose.yaw)),
            None,
        )
        for mark in found.layout.marks
    )
    return Surroundings(
        found.layout.extent, (*found.layout.walls, *walls), found.props, poses, (), found.layout.doors
    )


def check_names(file: WorldFile, surroundings: Surroundings) -> None:
    """Check that no generated thing, or body of a scene, has the name of another one.

    Raises:
        FileError: A name occurs twice.
    """
    taken = {wall.name for wall in surroundings.walls} | {"floor"}
    for prop in surroundings.props:
        if prop.name in taken:
            raise FileError(f"scene: duplicate name {prop.name!r} of a body and a wall; rename the wall")
    taken |= {prop.name for prop in surroundings.props} | {door.name for door in surroundings.doors}
    robots, props, cameras = ([each.name for each in of] for of in (file.robots, file.props, file.cameras))
    for kind, names in (("robots", robots), ("props", props), ("cameras", cameras)):
        for index, name in enumerate(names):
            if name in taken:
                raise FileError(f"{kind}.{index}.name: {name!r} is in use by another thing of the world")
    for kind, name in file.moving_names:
        if name in taken:
            raise FileError(
                f"the name {name!r} of a {kind} is in use by another thing of the world; rename the {kind}"
            )
    poses = {pose.name for pose in surroundings.poses}
    for index, pose in enumerate(file.poses):
        if pose.name in poses:
            raise FileError(f"poses.{index}.name: {pose.name!r} is in use by a generated pose")


def static_outlines(props: Sequence[Prop], ground: Ground = FLAT) -> tuple[Array, ...]:
    """Return the outlines of parts of static props, except those above all wheeled robots, or in the ground."""
    static = [(part, prop.state) for prop in props if prop.model.static for part in prop.model.parts]
    return tuple(
        outline(part, state)
        for part, state in static
        if lowest_of(part, state) - (floor := ground.height(*state.position[:2])) < OVERHEAD
        and highest_of(part, state) - floor > FLUSH
    )


def _standing(wall: WallFile, file: WorldFile) -> list[Wall]:
    """Return the boxes of a wall; segments are extended by half the thickness, which closes the corners."""
    height = wall.height or file.wall_height
    if wall.center is not None and wall.size is not None:
        return [Wall(wall.name, *wall.center, wall.yaw, *wall.size, height)]
    assert wall.points is not None
    thickness = wall.thickness or file.wall_thickness
    boxes = []
    for (ax, ay), (bx, by) in pairwise(wall.points):
        length = math.hypot(bx - ax, by - ay) + thickness
        yaw = math.atan2(by - ay, bx - ax)
        boxes.append(Wall(wall.name, (ax + bx) / 2, (ay + by) / 2, yaw, length, thickness, height))
    return boxes
