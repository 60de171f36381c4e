"""What simulator nodes and their clients say to each other: messages, verbs and key expressions. No I/O.

A request is a Zenoh query on `node_command(...)`, its payload the msgpack map of the verb's request model, its
answer that of the verb's reply model, or, as an error reply, a `Refusal`. Verbs, fields and result codes are
those of ROS `simulation_interfaces` 2.1 where it has them; what it lacks (time grants, robots, watches)
is named after the ROS messages and actions for the same purpose.

Units are SI, angles radians, the frame is the world's `map` unless a field says otherwise. Orientations are
roll, pitch, yaw after ISO 8855 (yaw first). Times are seconds of the simulator's clock.

The major version stands in every key. Within a major version fields are only added, with defaults, and
readers ignore what they do not know.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import IntEnum, IntFlag, StrEnum
from typing import Any, Generic, TypeVar

import msgpack
from pydantic import BaseModel, ConfigDict, ValidationError

MAJOR = 1
MAX_MESSAGE = 64 * 1024 * 1024  # [bytes]; larger payloads are refused unread


class Message(BaseModel):
    """Base of everything that crosses a process boundary."""

    model_config = ConfigDict(frozen=True, extra="ignore")


M = TypeVar("M", bound=Message)


class WireError(Exception):
    """A payload that is not the message it should be."""


def encode(message: Message) -> bytes:
    """The msgpack form of a message."""
    packed: bytes = msgpack.packb(message.model_dump(mode="python"), default=_plain)
    return packed


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | frozenset | set):
        return list(value)
    raise TypeError(f"{type(value).__name__} does not go over the wire")


def decode(kind: type[M], payload: bytes) -> M:
    """The message in a payload.

    Raises:
        WireError: The payload is too large, is no msgpack, or does not fit the model.
    """
    if len(payload) > MAX_MESSAGE:
        raise WireError(f"{kind.__name__} of {len(payload)} bytes exceeds the limit of {MAX_MESSAGE}")
    try:
        return kind.model_validate(msgpack.unpackb(payload, strict_map_key=True))
    except (ValueError, msgpack.UnpackException, ValidationError) as error:
        raise WireError(f"not a valid {kind.__name__}: {error}") from error


# ---------------------------------------------------------------- geometry


class Vector3(Message):
    """Three components along x, y, z."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


class Orientation(Message):
    """Roll, pitch, yaw [rad]."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Pose(Message):
    """Position [m] and orientation [rad]."""

    position: Vector3 = Vector3()
    orientation: Orientation = Orientation()


class Twist(Message):
    """Linear [m/s] and angular [rad/s] velocity."""

    linear: Vector3 = Vector3()
    angular: Vector3 = Vector3()


class EntityState(Message):
    """Where an entity is and how it moves."""

    pose: Pose = Pose()
    twist: Twist = Twist()


# ---------------------------------------------------------------- results


class Result(IntEnum):
    """Result codes of `simulation_interfaces`; those above 100 are each service's own."""

    FEATURE_UNSUPPORTED = 0
    OK = 1
    NOT_FOUND = 2
    INCORRECT_STATE = 3
    OPERATION_FAILED = 4


class SpawnResult(IntEnum):
    """Result codes of `spawn_entity` beyond the common ones."""

    NAME_NOT_UNIQUE = 101
    NAME_INVALID = 102
    UNSUPPORTED_FORMAT = 103
    NO_RESOURCE = 104
    NAMESPACE_INVALID = 105
    RESOURCE_PARSE_ERROR = 106
    MISSING_ASSETS = 107
    UNSUPPORTED_ASSETS = 108
    INVALID_POSE = 109


class StateResult(IntEnum):
    """Result codes of `set_simulation_state` beyond the common ones."""

    ALREADY_IN_TARGET_STATE = 101
    STATE_TRANSITION_ERROR = 102
    INCORRECT_TRANSITION = 103


class WorldResult(IntEnum):
    """Result codes of `load_world` and `unload_world` beyond the common ones."""

    UNSUPPORTED_FORMAT = 101
    NO_RESOURCE = 102
    RESOURCE_PARSE_ERROR = 103
    NO_WORLD_LOADED = 110


class Refusal(Message):
    """Why a request was not carried out: a result code and a sentence for people."""

    code: int
    message: str


# ---------------------------------------------------------------- simulator


class Empty(Message):
    """Nothing to say."""


class SimulationState(StrEnum):
    """States of `simulation_interfaces`; stopped is paused at the initial state."""

    STOPPED = "stopped"
    PLAYING = "playing"
    PAUSED = "paused"


class RobotInfo(Message):
    """A robot of the world.

    `kinds` are the actor types it can stand for, most specific first; `frames` the transform frames it has.
    """

    name: str
    kinds: tuple[str, ...]
    frames: tuple[str, ...]


class SimulatorFeatures(Message):
    """What a node is and has; answered at any time."""

    engine: str
    engine_version: str
    version: str  # of seoro
    features: tuple[str, ...]  # names of the verbs it serves
    spawn_formats: tuple[str, ...]  # such as "sdf"
    world: str
    available_worlds: tuple[str, ...]
    robots: tuple[RobotInfo, ...]
    time: float
    step: float  # length of one physics step [s]
    state: SimulationState


class LoadWorld(Message):
    """Load a world by name or path, and start over at time zero; an empty name is the world that is loaded."""

    world: str
    seed: int = 0


class SpawnEntity(Message):
    """Spawn an entity from the text of its model (`resource_string`); `uri` names it for people."""

    name: str
    uri: str
    resource_string: str
    initial_pose: Pose
    allow_renaming: bool = False


class EntityName(Message):
    """An entity by name."""

    name: str


class EntityFilter(Message):
    """Which entities: those whose whole name matches the regular expression."""

    filter: str = ".*"


class Entities(Message):
    """Names of entities, sorted."""

    names: tuple[str, ...]


class SetEntityState(Message):
    """Put an entity somewhere; None leaves that part as it is."""

    name: str
    pose: Pose | None = None
    twist: Twist | None = None


class SetSimulationState(Message):
    """Go to a simulation state."""

    state: SimulationState


class StepSimulation(Message):
    """Make physics steps; only while paused."""

    steps: int = 1


class ResetScope(IntFlag):
    """What a reset covers; `DEFAULT` is everything."""

    DEFAULT = 0
    TIME = 1
    STATE = 2
    SPAWNED = 4
    ALL = 255


class ResetSimulation(Message):
    """Reset; `scope` is a bit field of `ResetScope`."""

    scope: int = ResetScope.DEFAULT


class SimulationTime(Message):
    """The simulator's clock [s]."""

    time: float


# ---------------------------------------------------------------- time grants


class Outcome(StrEnum):
    """How a goal ended (as in ROS `action_msgs/GoalStatus`)."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Occurrence(Message):
    """A goal that ended or a watch that fired, by the id its client gave it."""

    id: str
    time: float
    outcome: Outcome
    message: str = ""


class Contact(Message):
    """Two entities began to touch; contact with the floor is not reported."""

    time: float
    first: str
    second: str


class Advance(Message):
    """Grant of time: simulate to `until`, or to the first occurrence or contact before it."""

    until: float


class Advanced(Message):
    """Answer to a grant: the time that was reached and everything that happened up to it, in order."""

    time: float
    occurrences: tuple[Occurrence, ...] = ()
    contacts: tuple[Contact, ...] = ()


# ---------------------------------------------------------------- robots


class SetInitialPose(Message):
    """Tell the localisation of a robot where it is."""

    robot: str
    pose: Pose


class NavigateThroughPoses(Message):
    """Drive a robot through poses, in order; one at a time, a new goal while one is active is refused.

    `stop_at_each` makes every pose a goal of its own, as `follow_waypoints` of Nav2 does. The end is
    reported as the `Occurrence` with this `id`.
    """

    id: str
    robot: str
    poses: tuple[Pose, ...]
    stop_at_each: bool = False


class CancelGoal(Message):
    """Cancel a goal: the robot stops, the goal ends as canceled. Unknown and ended goals are NOT_FOUND."""

    id: str


class StopRobot(Message):
    """Cancel whatever a robot does and command zero velocity."""

    robot: str


class WatchProximity(Message):
    """Report when `frame` is within `threshold` [m] of `point`, in the plane of `parent_frame`."""

    id: str
    frame: str
    parent_frame: str
    point: Vector3
    threshold: float


class WatchDistance(Message):
    """Report when the odometry of a robot has counted `distance` [m] more than now."""

    id: str
    robot: str
    distance: float


class CancelWatch(Message):
    """Forget a watch; unknown and fired ones are NOT_FOUND."""

    id: str


class RelativePose(Message):
    """A point `distance` [m] ahead of `frame`, in `parent_frame`."""

    frame: str
    parent_frame: str
    distance: float


# ---------------------------------------------------------------- what is left at the end


class Artifact(Message):
    """A file for the output folder of a run."""

    name: str
    media_type: str
    description: str
    data: bytes


class Artifacts(Message):
    """What a node has to show of the run so far."""

    artifacts: tuple[Artifact, ...]


# ---------------------------------------------------------------- verbs and keys

Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


@dataclass(frozen=True)
class Verb(Generic[Q, A]):
    """One thing a node can be asked: the name in the key, the models of request and answer."""

    name: str
    request: type[Q]
    answer: type[A]


GET_SIMULATOR_FEATURES = Verb("get_simulator_features", Empty, SimulatorFeatures)
LOAD_WORLD = Verb("load_world", LoadWorld, SimulatorFeatures)
SPAWN_ENTITY = Verb("spawn_entity", SpawnEntity, EntityName)
DELETE_ENTITY = Verb("delete_entity", EntityName, Empty)
GET_ENTITIES = Verb("get_entities", EntityFilter, Entities)
GET_ENTITY_STATE = Verb("get_entity_state", EntityName, EntityState)
SET_ENTITY_STATE = Verb("set_entity_state", SetEntityState, Empty)
SET_SIMULATION_STATE = Verb("set_simulation_state", SetSimulationState, Empty)
STEP_SIMULATION = Verb("step_simulation", StepSimulation, SimulationTime)
RESET_SIMULATION = Verb("reset_simulation", ResetSimulation, Empty)
ADVANCE = Verb("advance", Advance, Advanced)
SET_INITIAL_POSE = Verb("set_initial_pose", SetInitialPose, Empty)
NAVIGATE_THROUGH_POSES = Verb("navigate_through_poses", NavigateThroughPoses, Empty)
CANCEL_GOAL = Verb("cancel_goal", CancelGoal, Empty)
STOP_ROBOT = Verb("stop_robot", StopRobot, Empty)
WATCH_PROXIMITY = Verb("watch_proximity", WatchProximity, Empty)
WATCH_DISTANCE = Verb("watch_distance", WatchDistance, Empty)
CANCEL_WATCH = Verb("cancel_watch", CancelWatch, Empty)
GET_RELATIVE_POSE = Verb("get_relative_pose", RelativePose, Pose)
GET_ARTIFACTS = Verb("get_artifacts", Empty, Artifacts)

VERBS: tuple[Verb[Any, Any], ...] = tuple(value for value in globals().values() if isinstance(value, Verb))

_CHUNK = re.compile(r"[a-z0-9_-]+")


def _chunk(text: str) -> str:
    """A chunk of a key expression; only names that need no escaping are allowed."""
    if not _CHUNK.fullmatch(text):
        raise ValueError(f"{text!r} cannot name a node: use lower-case letters, digits, '_' and '-'")
    return text


def node_command(namespace: str, node: str, verb: str) -> str:
    """Key on which a node is asked to carry out a verb; `verb` may be `*` for all."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/node/{_chunk(node)}/cmd/{verb if verb == '*' else _chunk(verb)}"


def node_token(namespace: str, node: str, boot: str) -> str:
    """Liveliness token of a node; `boot` tells one start of it from the next."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/node/{_chunk(node)}/{_chunk(boot)}"


def node_tokens(namespace: str) -> str:
    """Key expression of the tokens of all nodes."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/node/*/*"


def token_node(key: str) -> tuple[str, str]:
    """Node and boot of a liveliness token's key."""
    *_, node, boot = key.split("/")
    return node, boot
