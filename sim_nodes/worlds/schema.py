"""Schema of world files. Unknown keys are errors."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from sim_nodes.agents.schema import CartFile, CrowdFile, PathFile, PersonFile, Speed, agent_names
from sim_nodes.buildings.schema import DoorFile, LiftFile, building_names
from sim_nodes.files import Declared
from sim_nodes.geodesy import GeoPoint
from sim_nodes.models.xml_reading import FRICTIONS, MASSES
from sim_nodes.robots.declaration import BatteryDeclaration
from sim_nodes.terrain.schema import MAX_PIECES, FloorFile, TerrainFile
from sim_nodes.views import DEFAULT_LENS, MAX_FOV, MAX_SIZE, MIN_FOV, MIN_SIZE
from sim_nodes.worlds.fields import Coordinate, Edge, Length, Name, Point, Share, Tags
from sim_nodes.worlds.generation.schema import GenerateFile
from sim_nodes.worlds.light import LightFile

MAX_WALLS = 500
MAX_ROBOTS = 64
MAX_CAMERAS = 16
MAX_PROPS = 100
MAX_POSES = 200
PROP_FORMS = ("box", "cube", "cylinder", "sphere", "model")
MAX_DESCRIPTION = 1000  # [characters]


class WallFile(Declared):
    """A wall: either along `points`, or a box with `center`, `size` and `yaw`.

    Walls belong to the entity `walls` unless they have a name of their own.
    """

    name: Name = "walls"
    points: Annotated[tuple[Point, ...], Field(min_length=2, max_length=200)] | None = None
    thickness: Annotated[float, Field(ge=0.02, le=2.0)] | None = None  # of a wall along `points`
    center: Point | None = None
    size: tuple[Length, Length] | None = None
    yaw: float = 0.0
    height: Length | None = None
    tags: Tags = ()

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if (self.points is None) == (self.center is None):
            raise ValueError("expected either `points`, or `center` and `size` of a wall")
        if (self.center is None) != (self.size is None):
            raise ValueError("expected both `center` and `size`")
        if self.center is not None and self.thickness is not None:
            raise ValueError("unexpected `thickness`: only walls along `points` have it")
        if self.points is not None and self.yaw:
            raise ValueError("unexpected `yaw`: only walls with `center` and `size` have it")
        if self.points is not None and any(math.dist(a, b) < 1e-3 for a, b in pairwise(self.points)):
            raise ValueError("two neighbouring `points` are equal")
        return self


class PoseFile(Declared):
    """Initial pose of a robot [m, rad]; `z` is the height of a fixed one.

    With `at`, the name of a pose of the world, x, y and yaw are relative to that pose. `start` is the free
    position nearest to the origin of the map, unless the world has a pose of this name.
    """

    at: Name | None = None
    x: Coordinate = 0.0
    y: Coordinate = 0.0
    z: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    yaw: float = 0.0


class BodyPoseFile(Declared):
    """Pose of a body [m, rad]; without `z` it is on the floor."""

    x: Coordinate = 0.0
    y: Coordinate = 0.0
    z: Coordinate | None = None
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class CylinderFile(Declared):
    """A cylinder along its z axis [m]."""

    radius: Edge
    length: Edge


class PropFile(Declared):
    """A body of the world: a shape, or a model in a file.

    Without `mass`, a shape is static and in the maps of robots.
    """

    name: Name
    box: tuple[Edge, Edge, Edge] | None = None
    cube: Edge | None = None  # edge length
    cylinder: CylinderFile | None = None
    sphere: Edge | None = None  # radius
    model: str | None = None  # an SDF, URDF or MJCF file, relative to the folder of the world
    mass: Annotated[float, Field(ge=MASSES[0], le=MASSES[1])] | None = None  # [kg] of a shape
    static: bool = False  # overrides the file of a model
    decompose: bool = False  # concave meshes of a model into convex pieces
    friction: Annotated[float, Field(ge=FRICTIONS[0], le=FRICTIONS[1])] = 1.0  # of a shape
    colour: tuple[Share, Share, Share] | None = None  # red, green, blue, from 0 to 1
    pose: BodyPoseFile = BodyPoseFile()
    tags: Tags = ()

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        forms = [form for form in PROP_FORMS if getattr(self, form) is not None]
        if len(forms) != 1:
            raise ValueError(
                f"expected one of {', '.join(PROP_FORMS)} in a prop, found {' and '.join(forms) or 'none'}"
            )
        if forms == ["model"]:
            if self.mass is not None or "friction" in self.model_fields_set:
                raise ValueError("unexpected `mass` or `friction`: a model has them in its file")
        elif "static" in self.model_fields_set:
            raise ValueError("unexpected `static`: only models have it; a shape without `mass` is static")
        elif "decompose" in self.model_fields_set:
            raise ValueError("unexpected `decompose`: only models have meshes")
        return self


class FloorPlanFile(Declared):
    """A floor plan, in the format of the ROS map server.

    Pixels darker than `occupied_thresh` (0 white, 1 black) are wall. Other pixels are floor, also the
    unknown pixels of a map server. With the mode `raw`, pixels of the value 100 are wall, without thresholds.
    """

    image: str  # PNG, PGM or JPEG, relative to the folder of the file
    resolution: Annotated[float, Field(ge=0.005, le=1.0)]  # [m] per pixel
    origin: tuple[Coordinate, Coordinate, float]  # corner of the lower left pixel: x, y [m], yaw [rad]
    negate: bool = False  # whether light pixels are wall
    occupied_thresh: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.65
    free_thresh: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.25
    mode: Literal["trinary", "scale", "raw"] = "trinary"  # `scale` has the walls of `trinary`

    @model_validator(mode="after")
    def _thresholds(self) -> Self:
        if self.free_thresh >= self.occupied_thresh:
            raise ValueError("expected `free_thresh` below `occupied_thresh`")
        return self


class RobotFile(Declared):
    """A robot: a kind that comes with the node, or the path of a declaration (.yaml)."""

    name: Name
    robot: str
    pose: PoseFile = PoseFile()
    battery: BatteryDeclaration | None = None  # replaces that of the declaration
    path: PathFile | None = None  # that it follows by its true pose, until a scenario commands it
    speed: Speed | None = None  # on the path [m/s]; its maximum by default
    tags: Tags = ()

    @model_validator(mode="after")
    def _speed_of_path(self) -> Self:
        if self.speed is not None and self.path is None:
            raise ValueError("unexpected `speed` without `path`; add a path, or remove it")
        return self


class CameraFile(Declared):
    """A free camera: its position, and a point to look at [m] or an orientation [rad]."""

    name: Name
    position: tuple[Coordinate, Coordinate, Coordinate]
    look_at: tuple[Coordinate, Coordinate, Coordinate] | None = None
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    fov: Annotated[float, Field(ge=MIN_FOV, le=MAX_FOV)] = DEFAULT_LENS.fov  # vertical [rad]
    width: Annotated[int, Field(ge=MIN_SIZE, le=MAX_SIZE)] = DEFAULT_LENS.width  # [pixels]
    height: Annotated[int, Field(ge=MIN_SIZE, le=MAX_SIZE)] = DEFAULT_LENS.height
    tags: Tags = ()

    @model_validator(mode="after")
    def _one_way_to_look(self) -> Self:
        if self.look_at is not None and (self.roll or self.pitch or self.yaw):
            raise ValueError("expected either `look_at`, or `roll`, `pitch` and `yaw` of a camera")
        if self.look_at == self.position:
            raise ValueError("`look_at` of a camera is its own position; expected another point")
        return self


class BoundsFile(Declared):
    """A box along the axes of a pose, by two corners [m]."""

    lower: tuple[Coordinate, Coordinate, Coordinate]
    upper: tuple[Coordinate, Coordinate, Coordinate]

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not all(low < high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError("expected `lower` below `upper` in x, y and z")
        return self


class NamedPoseFile(Declared):
    """A named pose, on the floor without `z`; `tags` give its purpose, `bounds` the free space around it."""

    name: Name
    description: Annotated[str, Field(max_length=MAX_DESCRIPTION)] = ""
    pose: BodyPoseFile
    bounds: BoundsFile | None = None
    tags: Tags = ()


class GeoOriginFile(Declared):
    """Place of the map's origin on the earth (WGS 84); x of the map is east, y north."""

    latitude: Annotated[float, Field(ge=-90.0, le=90.0)]  # degrees
    longitude: Annotated[float, Field(ge=-180.0, le=180.0)]  # degrees
    altitude: Annotated[float, Field(ge=-1000.0, le=100_000.0)] = 0.0  # above the ellipsoid [m]

    @property
    def point(self) -> GeoPoint:
        """The place as a point."""
        return GeoPoint(math.radians(self.latitude), math.radians(self.longitude), self.altitude)


class WorldFile(Declared):
    """A world file."""

    name: Name
    description: Annotated[str, Field(max_length=MAX_DESCRIPTION)] = ""
    tags: Tags = ()
    extent: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = None  # lower x, y, upper x, y
    floor_plan: FloorPlanFile | str | None = None  # or the name of a map file of the map server
    generate: GenerateFile | None = None
    scene: str | None = None  # an SDF, MJCF or URDF file, whose bodies are props
    geo_origin: GeoOriginFile | None = None
    floor: FloorFile = FloorFile()
    light: LightFile = LightFile()
    terrain: Annotated[tuple[TerrainFile, ...], Field(max_length=MAX_PIECES)] = ()
    wall_height: Length = 0.5
    wall_thickness: Annotated[float, Field(ge=0.02, le=2.0)] = 0.1
    walls: Annotated[tuple[WallFile, ...], Field(max_length=MAX_WALLS)] = ()
    robots: Annotated[tuple[RobotFile, ...], Field(max_length=MAX_ROBOTS)] = ()
    props: Annotated[tuple[PropFile, ...], Field(max_length=MAX_PROPS)] = ()
    cameras: Annotated[tuple[CameraFile, ...], Field(max_length=MAX_CAMERAS)] = ()
    poses: Annotated[tuple[NamedPoseFile, ...], Field(max_length=MAX_POSES)] = ()
    people: tuple[PersonFile, ...] = ()
    crowds: tuple[CrowdFile, ...] = ()
    carts: tuple[CartFile, ...] = ()
    doors: tuple[DoorFile, ...] = ()
    lifts: tuple[LiftFile, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        sources = (self.floor_plan, self.generate, self.scene)
        if self.extent is None and sources == (None, None, None):
            raise ValueError("expected `extent`, `floor_plan`, `generate` or `scene` of a world")
        if self.generate is not None and (self.extent, self.floor_plan, self.scene) != (None, None, None):
            raise ValueError("unexpected `extent`, `floor_plan` or `scene` beside `generate`, which makes them")
        if self.extent is not None:
            check_extent(self.extent)
        names = [robot.name for robot in self.robots]
        if len(set(names)) < len(names):
            raise ValueError("duplicate name of robots")
        taken = {wall.name for wall in self.walls} | {"walls", "floor"}
        if taken & set(names):
            raise ValueError(f"duplicate name of a robot and a wall: {', '.join(sorted(taken & set(names)))}")
        others = [
            *(("prop", prop.name) for prop in self.props),
            *(("camera", camera.name) for camera in self.cameras),
            *self.moving_names,
        ]
        for kind, name in others:
            if name in taken | set(names):
                raise ValueError(f"duplicate name {name!r} of a {kind}")
            names.append(name)
        if len({pose.name for pose in self.poses}) < len(self.poses):
            raise ValueError("duplicate name in `poses`")
        return self

    @property
    def moving_names(self) -> tuple[tuple[str, str], ...]:
        """Kinds and names of its people, carts, doors and lifts.

        Raises:
            ValueError: There are too many.
        """
        people = agent_names(self.people, self.crowds, self.carts)
        return (*people, *building_names(self.doors, self.lifts))


def check_extent(extent: tuple[float, float, float, float]) -> None:
    """Check the extent of a world.

    Raises:
        ValueError: The extent is invalid or too large.
    """
    left, bottom, right, top = extent
    if right - left < 1.0 or top - bottom < 1.0:
        raise ValueError("invalid `extent`; expected [lower x, lower y, upper x, upper y], at least 1 m wide")
    if (right - left) * (top - bottom) > 10_000.0:
        raise ValueError("`extent` is too large; expected at most 10000 m^2")
