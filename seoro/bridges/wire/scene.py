"""Description of a simulated world, to draw it: shapes of walls, robots and objects, the map, and named poses."""

from __future__ import annotations

from seoro.bridges.wire.limits import MAX_MESSAGE, Limits
from seoro.bridges.wire.listing import OccupancyGrid
from seoro.bridges.wire.message import Empty, Message, Query

MAX_SHAPES = 4000  # of a scene


class SceneShape(Message):
    """A shape at a pose: x, y, z [m], quaternion x, y, z, w, in the frame of its entity, or in `map`.

    `size` of a `box` is its three edges, of a `sphere` its radius, of a `polygon` its height. A `cylinder` or
    `capsule` has radius and length along z; the ends of a capsule are beyond. A polygon is an upright prism around
    its pose, whose outline has the corners `points`. A convex `hull` has `corners`, x, y, z of each one in
    little-endian floats of 32 bits [m], and `triangles`, three indices of one byte each, counterclockwise from
    outside. The shape moves with a `link` of its robot, or with the base if that is empty.
    """

    kind: str
    pose: tuple[float, ...]
    size: tuple[float, ...]
    points: tuple[tuple[float, float], ...] = ()
    corners: bytes = b""
    triangles: bytes = b""
    color: str  # "#rrggbb"
    link: str = ""
    entity: str = ""  # owner of a shape in `map`


class SceneLink(Message):
    """Pose of a link in the frame of its robot: x, y, z [m], quaternion x, y, z, w."""

    name: str
    pose: tuple[float, ...]


class SceneEntity(Message):
    """A robot or a movable object with its shapes, in the posture of that time."""

    name: str
    kind: str  # robot, object, person or door
    model: str = ""  # of a robot
    real: bool = False  # whether it is a robot of the real world
    footprint: tuple[tuple[float, float], ...] = ()  # of a robot, counterclockwise [m]
    height: float = 0.0  # of its highest point above its origin [m]
    shapes: tuple[SceneShape, ...] = ()
    links: tuple[SceneLink, ...] = ()  # with shapes that move against the base


class ScenePlace(Message):
    """A named pose: x, y [m] and yaw [rad]."""

    name: str
    pose: tuple[float, float, float]


class Scene(Message):
    """A world at a time of the simulator's clock [s]; poses are in the frame `map`."""

    time: float
    world: str
    simulator: str
    extent: tuple[float, float, float, float]  # lower x, lower y, upper x, upper y [m]
    shapes: tuple[SceneShape, ...] = ()  # of walls and static objects
    entities: tuple[SceneEntity, ...] = ()
    map: OccupancyGrid | None = None
    places: tuple[ScenePlace, ...] = ()
    omitted: int = 0  # shapes and pieces of terrain that are not described


GET_SCENE = Query("get_scene", Empty, Scene, reply_limits=Limits(MAX_MESSAGE, 400_000))
