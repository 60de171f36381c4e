"""Loads worlds by name or path: reads and validates them, and makes the scene for an engine."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, pairwise
from pathlib import Path

from seoro.files.inputs import Kind, read_input_text
from seoro.files.yaml_lines import FileError, Lines, read_yaml
from sim_nodes.extents import lowest_of, outline
from sim_nodes.files import bundled_names, validate
from sim_nodes.geometry import Array, Pose2, Vector, quaternion
from sim_nodes.physics import BodyState, PlacedRobot, Scene, Wall
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.reading import available_robots, load_robot, read_robot
from sim_nodes.views import Lens, View, looking_at
from sim_nodes.worlds.props import Prop, check_placement, read_prop
from sim_nodes.worlds.schema import CameraFile, NamedPoseFile, PropFile, RobotFile, WallFile, WorldFile

FOLDER = Path(__file__).parent
SUFFIXES = frozenset({".yaml", ".yml"})  # of world files
OVERHEAD = 0.5  # [m] above the floor; anything that starts higher is above robots and lidar beams


class WorldError(Exception):
    """An unknown world, or an invalid world file; `missing` distinguishes the two."""

    def __init__(self, message: str, *, missing: bool = False) -> None:
        super().__init__(message)
        self.missing = missing


@dataclass(frozen=True)
class NamedPose:
    """A named pose, and the free space around it: lower and upper corner of a box along its axes [m]."""

    name: str
    description: str
    tags: tuple[str, ...]
    place: BodyState
    room: tuple[Vector, Vector] | None


def read_pose(pose: NamedPoseFile, index: int, extent: tuple[float, float, float, float]) -> NamedPose:
    """Read a named pose of a world file.

    Args:
        pose: Entry of the file.
        index: Index of the entry, from 0.
        extent: Extent of the map: lower x, y, upper x, y [m].

    Raises:
        FileError: The pose is outside of the world.
    """
    at, (left, bottom, right, top) = pose.pose, extent
    if not (left <= at.x <= right and bottom <= at.y <= top):
        raise FileError(
            f"poses.{index}.pose: {pose.name!r} at ({at.x:g}, {at.y:g}) is outside of the world; "
            f"expected a position from ({left:g}, {bottom:g}) to ({right:g}, {top:g})"
        )
    place = BodyState((at.x, at.y, at.z or 0.0), quaternion(at.roll, at.pitch, at.yaw))
    room = None if pose.bounds is None else (pose.bounds.lower, pose.bounds.upper)
    return NamedPose(pose.name, pose.description, pose.tags, place, room)


@dataclass(frozen=True)
class World:
    """A world: its scene, and the extent of its map (lower x, lower y, upper x, upper y) [m].

    `description` and `tags` are those of its file, `entity_tags` those of entities by name, and `warnings` are
    about ignored parts of its files.
    """

    name: str
    extent: tuple[float, float, float, float]
    walls: tuple[Wall, ...]
    robots: tuple[PlacedRobot, ...]
    cameras: Mapping[str, View] = field(default_factory=dict)  # free cameras by name
    props: tuple[Prop, ...] = ()
    poses: tuple[NamedPose, ...] = ()
    entity_tags: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    description: str = ""
    tags: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def scene(self) -> Scene:
        """Scene for an engine."""
        return Scene(self.walls, self.robots, self.extent)

    @property
    def outlines(self) -> tuple[Array, ...]:
        """Outlines in the map besides walls: parts of static props, except those above all wheeled robots."""
        static = [(part, prop.state) for prop in self.props if prop.model.static for part in prop.model.parts]
        return tuple(outline(part, state) for part, state in static if lowest_of(part, state) < OVERHEAD)


def available_worlds() -> tuple[str, ...]:
    """Return the names of the worlds that come with the node."""
    return bundled_names(__package__)


def load_world(world: str) -> World:
    """Load a world by name or file.

    Args:
        world: One of `available_worlds()`, or the path of a `.yaml` file.

    Raises:
        WorldError: The world is unknown, or its file is invalid.
    """
    is_bundled = world in available_worlds()
    path = FOLDER / f"{world}.yaml" if is_bundled else Path(world)
    if path.suffix not in SUFFIXES:
        raise _unknown_world(world, path)
    try:
        text = read_input_text(path, Kind.WORLD)
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"cannot read the world file {world}: {error}", missing=True) from error
    return parse_world(text, path.name if is_bundled else world, path.parent)


def _unknown_world(world: str, path: Path) -> WorldError:
    known = ", ".join(available_worlds())
    if path.is_file():
        return WorldError(
            f"unsupported world format: {world}; expected a world file (.yaml), "
            "whose `props` name models in SDF, URDF and MJCF by `model`, and `floor_plan` names images by `image`"
        )
    return WorldError(f"unknown world {world!r} (worlds: {known}, or the path of a .yaml file)", missing=True)


def _check_no_map(content: object, source: str) -> None:
    """Refuse a map of the map server as a world; the message shows a world file that names it."""
    if isinstance(content, dict) and {"image", "resolution"} <= content.keys() and "name" not in content:
        name = Path(source).name
        raise WorldError(
            f"{source} is a map, not a world; expected a world file that names it: "
            f"`name: hall`, `floor_plan: {name}`, and `robots: [{{name: turtlebot4, robot: turtlebot4}}]`"
        )


def parse_world(text: str, source: str, folder: Path = Path()) -> World:
    """Parse the text of a world file.

    Args:
        text: Text of the file.
        source: Name of the file in messages.
        folder: Folder that relative file names start from.

    Raises:
        WorldError: The file is invalid; the message lists all errors.
    """
    file, lines = read_world_file(text, source)
    try:
        return _world(file, folder)
    except FileError as error:
        raise WorldError(lines.before(str(error))) from error


def read_world_file(text: str, source: str) -> tuple[WorldFile, Lines]:
    """Parse and validate the text of a world file by itself; returns it with its line numbers.

    Raises:
        WorldError: The text is invalid.
    """
    try:
        content = read_yaml(text, source)
        _check_no_map(content, source)
        lines = Lines(text, source)
        return validate(WorldFile, content, lines), lines
    except FileError as error:
        raise WorldError(str(error)) from error


def _world(file: WorldFile, folder: Path) -> World:
    warnings: tuple[str, ...] = ()
    walls = tuple(part for wall in file.walls for part in _standing(wall, file))
    extent = file.extent
    if file.floor_plan is not None:
        from sim_nodes.worlds.floor_plan import load_floor_plan  # noqa: PLC0415 - pictures, for worlds with one

        planned, covered, warnings = load_floor_plan(file.floor_plan, folder, file.wall_height)
        walls, extent = (*planned, *walls), extent or covered
    assert extent is not None, "the schema requires one of the two"
    robots = _robots(file, folder)
    check_placement(robots, extent)
    props = _props(file, folder)
    return World(
        file.name,
        extent,
        walls,
        robots,
        {camera.name: _camera(camera) for camera in file.cameras},
        tuple(chain.from_iterable(props)),
        tuple(read_pose(pose, index, extent) for index, pose in enumerate(file.poses)),
        _entity_tags(file),
        file.description,
        file.tags,
        (*warnings, *_notes(robots, props)),
    )


def _notes(robots: Sequence[PlacedRobot], props: Sequence[Sequence[Prop]]) -> Iterator[str]:
    """Yield the notes on the models of a world, those of each model once."""
    seen: set[tuple[str, ...]] = set()
    models = (
        *((f"robots.{index}", robot.declaration.notes) for index, robot in enumerate(robots)),
        *((f"props.{index}", prop.model.notes) for index, bodies in enumerate(props) for prop in bodies),
    )
    for place, notes in models:
        if notes not in seen:
            yield from (f"{place}: {note}" for note in notes)
        seen.add(notes)


def _props(file: WorldFile, folder: Path) -> list[tuple[Prop, ...]]:
    """Return the props of each entry of a file; a model may have several bodies."""
    taken = {entity.name for entity in _entities(file)}
    found = []
    for index, prop in enumerate(file.props):
        found.append(read_prop(prop, index, folder, taken))
        taken |= {body.name for body in found[-1]}
    return found


def _entities(file: WorldFile) -> tuple[WallFile | RobotFile | PropFile | CameraFile, ...]:
    return (*file.walls, *file.robots, *file.props, *file.cameras)


def _entity_tags(file: WorldFile) -> dict[str, tuple[str, ...]]:
    """Return the tags by entity; walls of one name have the tags of all of them."""
    tags: dict[str, dict[str, None]] = {}
    for entity in _entities(file):
        tags.setdefault(entity.name, {}).update(dict.fromkeys(entity.tags))
    return {name: tuple(of) for name, of in tags.items() if of}


def _robots(file: WorldFile, folder: Path) -> tuple[PlacedRobot, ...]:
    placed = []
    for index, robot in enumerate(file.robots):
        declaration = _declaration(robot.robot, f"robots.{index}.robot", folder)
        pose = Pose2(robot.pose.x, robot.pose.y, robot.pose.yaw)
        if robot.pose.z and not declaration.fixed:
            raise FileError(f"robots.{index}.pose.z: unexpected z: a {robot.robot} stands on the floor; remove it")
        if robot.battery is not None:
            if declaration.mobile is None:
                raise FileError(
                    f"robots.{index}.battery: unexpected battery: a {robot.robot} does not drive; remove it"
                )
            mobile = declaration.mobile.model_copy(update={"battery": robot.battery})
            declaration = declaration.model_copy(update={"mobile": mobile})
        placed.append(PlacedRobot(robot.name, declaration, pose, robot.pose.z))
    return tuple(placed)


def _declaration(robot: str, place: str, folder: Path) -> RobotDeclaration:
    if robot.endswith(".yaml"):
        return _own_robot(folder / robot, place)
    if robot not in available_robots():
        known = ", ".join(available_robots())
        raise FileError(
            f"{place}: unknown kind of robot {robot!r} (kinds: {known}, or the path of a declaration, .yaml)"
        )
    return load_robot(robot)


def _own_robot(path: Path, place: str) -> RobotDeclaration:
    try:
        return read_robot(path)
    except FileError as error:
        raise FileError(f"{place}: {error}") from error


def _camera(camera: CameraFile) -> View:
    if camera.look_at is not None:
        orientation = looking_at(camera.position, camera.look_at)
    else:
        orientation = quaternion(camera.roll, camera.pitch, camera.yaw)
    return View(camera.position, orientation, Lens(camera.fov, camera.width, camera.height))


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
