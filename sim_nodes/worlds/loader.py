"""Worlds by name or path: read, validated, and turned into the scene that an engine builds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from itertools import pairwise
from pathlib import Path

from pydantic import ValidationError

from seoro.bridges.wire.refusal import RequestRefused
from seoro.input_files import Kind, read_input_text
from sim_nodes.extents import lowest_of, outline
from sim_nodes.files import FileError, Lines, problems, read_yaml
from sim_nodes.geometry import Array, Pose2, quaternion
from sim_nodes.physics import PlacedRobot, Scene, Wall
from sim_nodes.robots.checking import check_urdf, line_of
from sim_nodes.robots.declaration import RobotDeclaration, available_robots, load_robot, read_robot
from sim_nodes.views import Lens, View, looking_at
from sim_nodes.worlds.places import check_places
from sim_nodes.worlds.poses import NamedPose, read_pose
from sim_nodes.worlds.props import Prop, read_prop
from sim_nodes.worlds.schema import CameraFile, PropFile, RobotFile, WallFile, WorldFile

SUFFIXES = frozenset({".yaml", ".yml"})  # of world files
OVERHEAD = 0.5  # [m] above the floor; what begins higher is in no robot's way, and above what its lidar sees


class WorldError(Exception):
    """A world that does not exist or whose file is wrong; `missing` tells the two apart."""

    def __init__(self, message: str, *, missing: bool = False) -> None:
        super().__init__(message)
        self.missing = missing


@dataclass(frozen=True)
class World:
    """A world: its scene, and the extent of its map (lower x, lower y, upper x, upper y) [m].

    `description` and `tags` are what its file says of it; `entity_tags` are those of entities, by their names;
    `warnings` are about what its files say and what is ignored.
    """

    name: str
    extent: tuple[float, float, float, float]
    walls: tuple[Wall, ...]
    robots: tuple[PlacedRobot, ...]
    cameras: Mapping[str, View] = field(default_factory=dict)  # free ones, by name
    props: tuple[Prop, ...] = ()
    poses: tuple[NamedPose, ...] = ()
    entity_tags: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    description: str = ""
    tags: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def scene(self) -> Scene:
        """What an engine builds."""
        return Scene(self.walls, self.robots, self.extent)

    @property
    def outlines(self) -> tuple[Array, ...]:
        """What the map has besides walls: parts of static props, but those above all that drives."""
        static = [(part, prop.state) for prop in self.props if prop.model.static for part in prop.model.parts]
        return tuple(outline(part, state) for part, state in static if lowest_of(part, state) < OVERHEAD)


def available_worlds() -> tuple[str, ...]:
    """Names of the worlds that come with the node."""
    files = resources.files(__package__).iterdir()
    return tuple(sorted(entry.name.removesuffix(".yaml") for entry in files if entry.name.endswith(".yaml")))


def load_world(world: str) -> World:
    """The world of a name, or in a file.

    Args:
        world: One of `available_worlds()`, or the path of a `.yaml` file.

    Raises:
        WorldError: There is no such world, or its file is wrong.
    """
    if world in available_worlds():
        text = resources.files(__package__).joinpath(f"{world}.yaml").read_text(encoding="utf-8")
        return parse_world(text, f"{world}.yaml", Path(__file__).parent)
    path = Path(world)
    if path.suffix not in SUFFIXES:
        raise _no_world_file(world, path)
    try:
        text = read_input_text(path, Kind.WORLD)
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"cannot read the world file {world}: {error}", missing=True) from error
    return parse_world(text, world, path.parent)


def _no_world_file(world: str, path: Path) -> WorldError:
    known = ", ".join(available_worlds())
    if path.is_file():
        return WorldError(
            f"{world} is no world file of seoro (.yaml), in which `props` name models in SDF, URDF and MJCF by "
            "`model`, and `floor_plan` names pictures by `image`; worlds in SDF or MJCF are unsupported"
        )
    return WorldError(
        f"there is no world {world!r}: known are {known}, or give the path of a .yaml file", missing=True
    )


def _check_no_map(content: object, source: str) -> None:
    """Refuse a map of the map server in the place of a world, and say how a world names it."""
    if isinstance(content, dict) and {"image", "resolution"} <= content.keys() and "name" not in content:
        name = Path(source).name
        raise WorldError(
            f"{source} is a map, not a world; expected a world file that names it: "
            f"`name: hall`, `floor_plan: {name}`, and `robots: [{{name: turtlebot4, robot: turtlebot4}}]`"
        )


def parse_world(text: str, source: str, folder: Path = Path()) -> World:
    """The world that the text of a world file describes.

    Args:
        text: The text.
        source: What messages call the file.
        folder: The folder from which it names others.

    Raises:
        WorldError: The file is wrong; the message lists everything that is.
    """
    file, lines = read_world_file(text, source)
    try:
        return _world(file, folder)
    except FileError as error:
        raise WorldError(lines.before(str(error))) from error


def read_world_file(text: str, source: str) -> tuple[WorldFile, Lines]:
    """What the text of a world file says, by itself, and where.

    Raises:
        WorldError: The text is wrong.
    """
    try:
        content = read_yaml(text, source)
        _check_no_map(content, source)
        lines = Lines(text, source)
        return WorldFile.model_validate(content), lines
    except FileError as error:
        raise WorldError(str(error)) from error
    except ValidationError as error:
        raise WorldError(problems(error, lines, WorldFile)) from error


def _world(file: WorldFile, folder: Path) -> World:
    warnings: tuple[str, ...] = ()
    walls = tuple(part for wall in file.walls for part in _standing(wall, file))
    extent = file.extent
    if file.floor_plan is not None:
        from sim_nodes.worlds.floor_plan import load_floor_plan  # noqa: PLC0415 - pictures, for worlds with one

        planned, covered, warnings = load_floor_plan(file.floor_plan, folder, file.wall_height)
        walls, extent = (*planned, *walls), extent or covered
    assert extent is not None, "the schema asks for one or the other"
    robots = _robots(file, folder)
    check_places(robots, extent)
    cameras = {camera.name: _camera(camera) for camera in file.cameras}
    props = tuple(read_prop(prop, index, folder) for index, prop in enumerate(file.props))
    poses = tuple(read_pose(pose, index, extent) for index, pose in enumerate(file.poses))
    return World(
        file.name,
        extent,
        walls,
        robots,
        cameras,
        props,
        poses,
        _entity_tags(file),
        file.description,
        file.tags,
        warnings,
    )


def _entity_tags(file: WorldFile) -> dict[str, tuple[str, ...]]:
    """The tags of entities; walls of one name have those of all of them."""
    tags: dict[str, dict[str, None]] = {}
    entities: tuple[WallFile | RobotFile | PropFile | CameraFile, ...]
    entities = (*file.walls, *file.robots, *file.props, *file.cameras)
    for entity in entities:
        tags.setdefault(entity.name, {}).update(dict.fromkeys(entity.tags))
    return {name: tuple(of) for name, of in tags.items() if of}


def _robots(file: WorldFile, folder: Path) -> tuple[PlacedRobot, ...]:
    placed = []
    for index, robot in enumerate(file.robots):
        declaration = _declaration(robot.robot, f"robots.{index}.robot", folder)
        pose = Pose2(robot.pose.x, robot.pose.y, robot.pose.yaw)
        if robot.pose.z and not declaration.fixed:
            raise FileError(f"robots.{index}.pose.z: a {robot.robot} stands on the floor, leave z out")
        if robot.battery is not None:
            if declaration.mobile is None:
                raise FileError(f"robots.{index}.battery: a {robot.robot} does not drive, leave it out")
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
            f"{place}: unknown kind {robot!r}, known are {known}, or give the path of a declaration (.yaml)"
        )
    return load_robot(robot)


def _own_robot(path: Path, place: str) -> RobotDeclaration:
    try:
        declaration = read_robot(path)
    except FileError as error:
        raise FileError(f"{place}: {error}") from error
    try:
        check_urdf(declaration)
    except RequestRefused as error:
        where = f" (line {line})" if (line := line_of(declaration.urdf, error.message)) is not None else ""
        raise FileError(f"{place}: the URDF of {path}{where}: {error.message}") from error
    return declaration


def _camera(camera: CameraFile) -> View:
    if camera.look_at is not None:
        orientation = looking_at(camera.position, camera.look_at)
    else:
        orientation = quaternion(camera.roll, camera.pitch, camera.yaw)
    return View(camera.position, orientation, Lens(camera.fov, camera.width, camera.height))


def _standing(wall: WallFile, file: WorldFile) -> list[Wall]:
    """The boxes of a wall; segments are prolonged by half the thickness, so that corners are closed."""
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
