"""Contents of worlds: entities, named poses, maps, frames, models and robots."""

from __future__ import annotations

from seoro.bridges.wire.entities import Bounds, EntityFilter, EntityName, TagsFilter
from seoro.bridges.wire.geometry import EntityState
from seoro.bridges.wire.limits import BYTES
from seoro.bridges.wire.message import Empty, Message, Query, Verb
from seoro.bridges.wire.simulator import RobotName, SimulationState
from seoro.robotics.geometry import Pose3D


class EntityStates(Message):
    """Entities by their names, sorted, with their states."""

    names: tuple[str, ...]
    states: tuple[EntityState, ...]


class EntityInfo(Message):
    """Description of an entity: `description` is free text, `tags` select it."""

    category: int
    description: str
    tags: tuple[str, ...] = ()


class SetEntityInfo(Message):
    """Replace the description of an entity."""

    name: str
    info: EntityInfo


class EntityBounds(Message):
    """Bounding box of an entity along its own axes, at its present joint positions; None without a shape."""

    bounds: Bounds | None


class CurrentWorld(Message):
    """The loaded world: its name, and the requested name or path.

    `source` is empty for the world of a snapshot.
    """

    name: str
    source: str
    description: str = ""
    tags: tuple[str, ...] = ()


class GetAvailableWorlds(Message):
    """List the worlds with some tags: those of the node, and those in `sources`.

    Sources are folders on the machine of the node, each a path or `file://PATH`.
    """

    tags: TagsFilter = TagsFilter()
    sources: tuple[str, ...] = ()


class WorldInfo(Message):
    """World by its `source`, a name or a path for `load_world`, with the description of its file."""

    source: str
    description: str
    tags: tuple[str, ...]


class AvailableWorlds(Message):
    """Worlds by names or paths; `message` reports invalid sources and omitted worlds."""

    names: tuple[str, ...]
    worlds: tuple[WorldInfo, ...] = ()
    message: str = ""


class CurrentState(Message):
    """Simulation state, and the simulator's clock [s]."""

    state: SimulationState
    time: float


class Transform(Message):
    """Pose of a frame in `map`; None until its robot is localised."""

    frame: str
    pose: Pose3D | None


class Transforms(Message):
    """All frames. The true frame of a robot is called NAME_base_link_gt."""

    transforms: tuple[Transform, ...]


class NamedPose(Message):
    """Pose with a name; `description` is free text, `tags` state its purpose."""

    name: str
    description: str
    tags: tuple[str, ...]
    pose: Pose3D


class NamedPoses(Message):
    """Named poses, in the order of the world's file."""

    poses: tuple[NamedPose, ...]


class PoseName(Message):
    """A named pose by name."""

    name: str


class NamedPoseBounds(Message):
    """Free space at a named pose, along its own axes; None if unknown."""

    bounds: Bounds | None


class OccupancyGrid(Message):
    """Static obstacles in square cells, one byte each: 100 is occupied, 0 is free.

    `x` and `y` are the lower corner in `map` [m]. Cells are ordered by y, then by x.
    """

    resolution: float  # [m]
    x: float
    y: float
    columns: int
    rows: int
    cells: bytes


class GetSpawnables(Message):
    """List the models that can be spawned by `uri` alone.

    A node searches its model path and the props of its world. `sources` are further folders on the machine of the
    node, each a path or `file://PATH`.
    """

    sources: tuple[str, ...] = ()


class Spawnable(Message):
    """Model by its `uri`: its description for people, and its bounding box along its own axes."""

    uri: str
    description: str
    bounds: Bounds


class Spawnables(Message):
    """Models that can be spawned; `message` reports invalid sources and omitted models."""

    spawnables: tuple[Spawnable, ...]
    message: str = ""


class LidarDescription(Message):
    """Planar lidar: its link, its yaw from the base [rad], and its range [m]."""

    link: str
    yaw: float
    range_min: float
    range_max: float
    rate: float  # [Hz]


class ArmDescription(Message):
    """Position-controlled joints, those of an arm in order from the base.

    `fingers` are the joints of its gripper and `stroke` their maximum opening [m]: none and 0 without a gripper.
    `postures` are the names for `take_posture`.
    """

    joints: tuple[str, ...]
    fingers: tuple[str, ...]
    stroke: float
    postures: tuple[str, ...] = ()


class MountedSensor(Message):
    """Camera or listed sensor of a robot: its kind, rate, and pose on its link, with x ahead and z up.

    Optics are set for sensors with pixels, ranges for distances, and `aperture` for sonars. `deviations` are
    standard deviations of a receiver's east, north and altitude [m]. Other fields are zero or empty.
    """

    name: str
    kind: str  # `camera`, or a kind of the list `sensors`
    link: str
    pose: Pose3D
    rate: float  # [Hz]
    fov: float = 0.0  # vertical [rad]
    width: int = 0  # [pixels]
    height: int = 0
    range_min: float = 0.0  # [m]
    range_max: float = 0.0
    aperture: float = 0.0  # full angle of the cone [rad]
    deviations: tuple[float, ...] = ()


class RobotDescription(Message):
    """Robot: the text of its URDF, its base link, the names of its sensors, and its parts.

    `urdf` is empty if the node has none. `max_speed` [m/s] and `max_turn_rate` [rad/s] are zero for robots that do
    not drive.
    """

    urdf: str
    base_link: str
    sensors: tuple[str, ...]
    lidar: LidarDescription | None = None
    arm: ArmDescription | None = None
    max_speed: float = 0.0
    max_turn_rate: float = 0.0
    has_battery: bool = False
    mounted: tuple[MountedSensor, ...] = ()


GET_ENTITIES_STATES = Query("get_entities_states", EntityFilter, EntityStates)
GET_ENTITY_INFO = Query("get_entity_info", EntityName, EntityInfo)
SET_ENTITY_INFO = Verb("set_entity_info", SetEntityInfo, Empty)
GET_ENTITY_BOUNDS = Query("get_entity_bounds", EntityName, EntityBounds)
GET_CURRENT_WORLD = Query("get_current_world", Empty, CurrentWorld)
GET_AVAILABLE_WORLDS = Query("get_available_worlds", GetAvailableWorlds, AvailableWorlds)
GET_SIMULATION_STATE = Query("get_simulation_state", Empty, CurrentState)
GET_TRANSFORMS = Query("get_transforms", Empty, Transforms)
GET_NAMED_POSES = Query("get_named_poses", TagsFilter, NamedPoses)
GET_NAMED_POSE_BOUNDS = Query("get_named_pose_bounds", PoseName, NamedPoseBounds)
GET_MAP = Query("get_map", Empty, OccupancyGrid, reply_limits=BYTES)
GET_SPAWNABLES = Query("get_spawnables", GetSpawnables, Spawnables)
GET_ROBOT_DESCRIPTION = Query("get_robot_description", RobotName, RobotDescription)
