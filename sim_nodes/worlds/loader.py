"""Loads worlds by name or path: reads and validates them, and makes the scene for an engine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from itertools import chain
from pathlib import Path

from seoro.deferred import dataclass
from seoro.files.inputs import Kind, read_input_text
from seoro.files.world_names import WORLD_FILES, WorldName
from seoro.files.yaml_lines import FileError, Lines, read_yaml, validate
from sim_nodes.agents.schema import AgentFile
from sim_nodes.buildings.parts import BuildingPart, make_door, make_lift
from sim_nodes.buildings.schema import MAX_PARTS
from sim_nodes.departures import is_within
from sim_nodes.files import bundled_names
from sim_nodes.geodesy import GeoPoint
from sim_nodes.geometry import Array, quaternion
from sim_nodes.navigation.maps import build_map
from sim_nodes.physics import PlacedRobot, Scene, Wall
from sim_nodes.terrain.ground import FLAT, Ground
from sim_nodes.terrain.placing import grounded
from sim_nodes.terrain.reading import read_ground
from sim_nodes.views import DAYLIGHT, Lens, Light, View, looking_at
from sim_nodes.worlds.paths import RobotPath, read_paths
from sim_nodes.worlds.poses import START_RADIUS, NamedPose, free_start, read_pose
from sim_nodes.worlds.props import Prop, check_placement, read_prop
from sim_nodes.worlds.robots import placed_robots
from sim_nodes.worlds.schema import CameraFile, PropFile, RobotFile, WallFile, WorldFile
from sim_nodes.worlds.sources import START, as_world, described
from sim_nodes.worlds.surroundings import Surroundings, check_names, read_surroundings, static_outlines

FOLDER = Path(__file__).parent


class WorldError(Exception):
    """An unknown world, or an invalid world file; `missing` distinguishes the two."""

    def __init__(self, message: str, *, missing: bool = False) -> None:
        super().__init__(message)
        self.missing = missing


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
    agents: tuple[AgentFile, ...] = ()  # people, crowds and carts
    building: tuple[BuildingPart, ...] = ()  # doors and lifts
    entity_tags: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    description: str = ""
    tags: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    origin: GeoPoint | None = None  # of the map
    ground: Ground = FLAT
    light: Light = DAYLIGHT
    paths: Mapping[str, RobotPath] = field(default_factory=dict)  # of robots by name

    @property
    def scene(self) -> Scene:
        """Scene for an engine."""
        return Scene(self.walls, self.robots, self.extent, self.ground, self.light)

    @property
    def outlines(self) -> tuple[Array, ...]:
        """Outlines in the map besides walls; see `static_outlines`."""
        return static_outlines(self.props, self.ground)


def available_worlds() -> tuple[str, ...]:
    """Return the names of the worlds that come with the node."""
    return bundled_names(__package__)


def load_world(world: str, seed: int = 0) -> World:
    """Load a world by name or file.

    Args:
        world: One of `available_worlds()`, or the path of a file, perhaps with parameters
            (`seoro.files.world_names`).
        seed: Seed of the run, for generated worlds.

    Raises:
        WorldError: The world is unknown, or its file is invalid.
    """
    name, path, source = _locate(world)
    return parse_world(_text(path, source), source, path.parent, name.parameters, seed)


def read_described(world: str) -> tuple[WorldFile, Path]:
    """Return the content of a world file with its parameters, and its path; other files are not read.

    Raises:
        WorldError: The world is unknown, or the file is invalid by itself.
    """
    name, path, source = _locate(world)
    file, _ = read_world_file(_text(path, source), source, name.parameters)
    return file, path


def _text(path: Path, source: str) -> str:
    try:
        return read_input_text(path, Kind.WORLD) if path.suffix.lower() in WORLD_FILES else described(path)
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"cannot read the world file {source}: {error}", missing=True) from error


def _locate(world: str) -> tuple[WorldName, Path, str]:
    """Return the parsed name of a world, the path of its file, and the name of this in messages.

    Raises:
        WorldError: The world is unknown.
    """
    name = WorldName.parse(world)
    if name.world in available_worlds():
        file = f"{name.world}.yaml"
        return name, FOLDER / file, file
    path = Path(name.world)
    if name.is_file:
        return name, path, name.world
    known = ", ".join(available_worlds())
    if path.is_file():
        raise WorldError(
            f"unsupported world format: {name.world}; expected a world file (.yaml), a map or picture of a floor "
            "(.yaml, .png, .pgm, .jpg), or a scene (.sdf, .world, .xml)"
        )
    raise WorldError(f"unknown world {name.world!r} (worlds: {known}, or the path of a .yaml file)", missing=True)


def parse_world(text: str, source: str, folder: Path = Path(), parameters: str = "", seed: int = 0) -> World:
    """Parse the text of a world file.

    Args:
        text: Text of the file.
        source: Name of the file in messages.
        folder: Folder that relative file names start from.
        parameters: Other values of keys; see `set_parameters`.
        seed: Seed of the run, for generated worlds.

    Raises:
        WorldError: The file is invalid; the message lists all errors.
    """
    file, lines = read_world_file(text, source, parameters)
    try:
        return _world(file, folder, seed)
    except FileError as error:
        raise WorldError(lines.before(str(error))) from error


def read_world_file(text: str, source: str, parameters: str = "") -> tuple[WorldFile, Lines]:
    """Parse and validate the text of a world file by itself; returns it with its line numbers.

    The text may be a map of the map server, which is a world with a TurtleBot 4.

    Raises:
        WorldError: The text is invalid.
    """
    try:
        content = as_world(read_yaml(text, source), source, parameters)
        lines = Lines(text, source)
        return validate(WorldFile, content, lines), lines
    except FileError as error:
        raise WorldError(str(error)) from error


def _world(file: WorldFile, folder: Path, seed: int) -> World:
    surroundings = read_surroundings(file, folder, seed)
    extent = surroundings.extent
    check_names(file, surroundings)
    ground = read_ground(file.floor, file.terrain, folder, seed, extent)
    walls = tuple(grounded(ground, wall) for wall in surroundings.walls)
    placed = _props(file, folder, ground)
    props = (*surroundings.props, *chain.from_iterable(placed))
    poses = (
        *surroundings.poses,
        *(read_pose(pose, index, extent, ground) for index, pose in enumerate(file.poses)),
    )
    starts = {pose.name: pose.place.planar for pose in poses}
    outlines = static_outlines(props, ground)
    if START not in starts and any(robot.pose.at == START for robot in file.robots):
        starts[START] = free_start(build_map(extent, walls, outlines), START_RADIUS)
    robots = placed_robots(file, folder, starts, ground)
    check_placement(robots, extent)
    building = _building(file, surroundings, ground)
    has_paths = any(robot.path is not None for robot in file.robots)
    paths = read_paths(file.robots, robots, build_map(extent, walls, outlines)) if has_paths else {}
    return World(
        file.name,
        extent,
        walls,
        robots,
        {camera.name: _camera(camera) for camera in file.cameras},
        props,
        poses,
        (*file.people, *file.crowds, *file.carts),
        building,
        _entity_tags(file) | {name: part.tags for part in building for name, _ in part.bodies if part.tags},
        file.description,
        file.tags,
        (*surroundings.warnings, *_notes(robots, placed)),
        None if file.geo_origin is None else file.geo_origin.point,
        ground,
        file.light.light,
        paths,
    )


def _building(file: WorldFile, surroundings: Surroundings, ground: Ground) -> tuple[BuildingPart, ...]:
    doors = ((f"doors.{index}", door.name, door.pose) for index, door in enumerate(file.doors))
    lifts = ((f"lifts.{index}", lift.name, lift.pose) for index, lift in enumerate(file.lifts))
    for place, name, pose in (*doors, *lifts):
        if not is_within((pose.x, pose.y, 0.0), surroundings.extent):
            left, bottom, right, top = surroundings.extent
            raise FileError(
                f"{place}.pose: {name!r} at ({pose.x:g}, {pose.y:g}) is outside of the world; "
                f"expected a position from ({left:g}, {bottom:g}) to ({right:g}, {top:g})"
            )
    found = (*surroundings.doors, *file.doors)
    if (count := len(found) + len(file.lifts)) > MAX_PARTS:
        raise FileError(f"generate: found {count} doors and lifts; expected at most {MAX_PARTS}")
    return (
        *(make_door(door, file.wall_height, ground) for door in found),
        *(make_lift(lift, ground) for lift in file.lifts),
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


def _props(file: WorldFile, folder: Path, ground: Ground) -> list[tuple[Prop, ...]]:
    """Return the props of each entry of a file; a model may have several bodies."""
    taken = {entity.name for entity in _entities(file)}
    taken |= {name for _, name in file.moving_names}
    found = []
    for index, prop in enumerate(file.props):
        found.append(read_prop(prop, index, folder, taken, ground))
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


def _camera(camera: CameraFile) -> View:
    if camera.look_at is not None:
        orientation = looking_at(camera.position, camera.look_at)
    else:
        orientation = quaternion(camera.roll, camera.pitch, camera.yaw)
    return View(camera.position, orientation, Lens(camera.fov, camera.width, camera.height))
