"""Props of a world, which belong to it from the start, and checks of the initial poses of robots."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from seoro.bridges.model_files import InvalidModel, gather
from seoro.bridges.wire import WorldResult
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.deferred import dataclass
from seoro.files.yaml_lines import FileError
from sim_nodes.extents import FLOOR_TOLERANCE, lowest_point
from sim_nodes.geometry import quaternion, vector
from sim_nodes.models import parse_bodies
from sim_nodes.models.scenes import SceneBody
from sim_nodes.models.settings import ModelSettings
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Engine, Part, PlacedRobot, Shape, Sphere
from sim_nodes.spawning import placed_bodies
from sim_nodes.terrain.ground import FLAT, Ground
from sim_nodes.terrain.placing import height_under
from sim_nodes.worlds.schema import PropFile


@dataclass(frozen=True)
class Prop:
    """A body of a world, and its initial state."""

    name: str
    model: BodyModel
    state: BodyState


def read_prop(
    prop: PropFile, index: int, folder: Path, taken: Collection[str], ground: Ground = FLAT
) -> tuple[Prop, ...]:
    """Read a prop of a world file; a model with several bodies is several props.

    Args:
        prop: Entry of the file.
        index: Index of the entry, from 0.
        folder: Folder that relative file names start from.
        taken: Names in use.
        ground: Ground of the world, on which it stands.

    Raises:
        FileError: Its model is unreadable or invalid, or the prop would be below the floor.
    """
    bodies = _bodies(prop, index, folder)
    pose = prop.pose
    state = BodyState((pose.x, pose.y, 0.0), quaternion(pose.roll, pose.pitch, pose.yaw))
    placed = placed_bodies(prop.name, bodies, state, taken)
    needed = -min(lowest_point(model, state) for model, state in placed.values())
    # Shapes stand on the ground; models are at their own height above it, if they are not below the floor.
    usual = needed if prop.model is None else max(needed, 0.0)
    usual += max(height_under(ground, model, state) for model, state in placed.values())
    z = usual if pose.z is None else pose.z
    if z < needed - FLOOR_TOLERANCE:
        raise FileError(
            f"props.{index}.pose.z: {prop.name!r} would be {needed - z:.3f} m below the floor; "
            f"expected z of {needed:.3f} m or more, or none"
        )
    lift = (0.0, 0.0, z)
    return tuple(
        Prop(name, model, replace(state, position=vector(np.add(state.position, lift))))
        for name, (model, state) in placed.items()
    )


def _bodies(prop: PropFile, index: int, folder: Path) -> tuple[SceneBody, ...]:
    colour = None if prop.colour is None else (*prop.colour, 1.0)
    if prop.model is None:
        parts = (Part(_shape(prop)),)
        static = prop.mass is None
        model = BodyModel(parts, prop.mass or 1.0, prop.friction, static=static, colour=colour)
        return (SceneBody(prop.name, model, BodyState((0.0, 0.0, 0.0))),)
    try:
        found = gather(folder / prop.model, expands=True)
        return parse_bodies(found.text, found.files, ModelSettings(prop.static, colour, prop.decompose))
    except InvalidModel as error:
        raise FileError(f"props.{index}.model: {error}") from error
    except RequestRefused as error:
        raise FileError(f"props.{index}.model: {prop.model}: {error.message}") from error


def _shape(prop: PropFile) -> Shape:
    if prop.box is not None:
        return Box(prop.box)
    if prop.cube is not None:
        return Box((prop.cube, prop.cube, prop.cube))
    if prop.cylinder is not None:
        return Cylinder(prop.cylinder.radius, prop.cylinder.length)
    assert prop.sphere is not None, "the schema requires one form"
    return Sphere(prop.sphere)


FIXED = 0.05  # [m] minimum radius about the origin of a fixed robot
TOUCH = 1e-3  # [m] by which circles about robots may overlap
STOREY = 0.3  # [m] minimum difference of heights between robots above each other


def check_placement(robots: Sequence[PlacedRobot], extent: tuple[float, float, float, float]) -> None:
    """Check the initial poses of the robots of a world.

    Args:
        robots: Robots in the order of the world file.
        extent: Lower x, lower y, upper x, upper y of the map [m].

    Raises:
        FileError: A robot is outside of the map or overlaps another; the message begins with its key in the file.
    """
    left, lower, right, upper = extent
    for index, robot in enumerate(robots):
        x, y = robot.pose.x, robot.pose.y
        if not (left <= x <= right and lower <= y <= upper):
            raise FileError(
                f"robots.{index}.pose: {robot.name!r} at x {x:g} m, y {y:g} m is outside of the world; expected "
                f"x from {left:g} to {right:g} m and y from {lower:g} to {upper:g} m"
            )
    for (_, one), (index, other) in combinations(enumerate(robots), 2):
        needed, distance = _radius(one) + _radius(other), one.pose.distance(other.pose.x, other.pose.y)
        if distance < needed - TOUCH and abs(one.height - other.height) < STOREY:
            raise FileError(
                f"robots.{index}.pose: {other.name!r} is {distance:.3f} m from {one.name!r}; expected "
                f"{needed:.3f} m or more, so that they do not overlap"
            )


def _radius(robot: PlacedRobot) -> float:
    mobile = robot.declaration.mobile
    return FIXED if mobile is None else mobile.radius


def check_start_poses(engine: Engine, world: str, robots: Sequence[PlacedRobot]) -> None:
    """Check that robots do not start inside walls, props or one another.

    The base of a fixed robot is ignored: it may be sunk into its pedestal.

    Args:
        engine: Engine with the world in its initial state.
        world: Name of the world.
        robots: Robots of the world.

    Raises:
        RequestRefused: A robot overlaps something; the message names both and the pose.
    """
    for robot in robots:
        found = _overlaps(engine, robot)
        if found:
            where = f"x {robot.pose.x:g} m, y {robot.pose.y:g} m"
            raise RequestRefused(
                WorldResult.RESOURCE_PARSE_ERROR,
                f"{world}: the robot {robot.name!r} at {where} overlaps {name_list(found)}; "
                "expected a `pose` at which nothing overlaps it",
            )


def _overlaps(engine: Engine, robot: PlacedRobot) -> tuple[str, ...]:
    """Return the names of the entities that a robot overlaps, sorted."""
    arm = robot.declaration.arm
    if not robot.declaration.fixed:
        return engine.overlaps(robot.name)
    if arm is None:
        return ()
    home = np.array([joint.home for joint in arm.joints])
    return tuple(sorted({overlap.other for overlap in engine.arm_overlaps(robot.name, home, (), None)}))
