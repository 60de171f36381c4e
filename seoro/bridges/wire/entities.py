"""What is in the world: spawned, found, moved, deleted."""

from __future__ import annotations

from seoro.bridges.wire.filters import EntityFilter
from seoro.bridges.wire.geometry import EntityState, Pose, Twist
from seoro.bridges.wire.limits import ANSWER, MEBIBYTE, Limits
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.results import Result


class SpawnEntity(Message):
    """Spawn an entity from the text of its model, which `uri` names for people then.

    Without a text, the model is that of the `uri`, one of those that `get_spawnables` tells, or another along the
    node's model path. `tags` are what the entity is found by later.
    """

    name: str
    uri: str
    resource_string: str = ""
    initial_pose: Pose
    allow_renaming: bool = False
    tags: tuple[str, ...] = ()


class SpawnEntities(Message):
    """Spawn several entities, each as if those before it were there already."""

    entities: tuple[SpawnEntity, ...]


class Spawning(Message):
    """What became of one of several entities: its name, or the result code and the reason why there is none."""

    name: str
    code: int = Result.OK
    message: str = ""


class Spawnings(Message):
    """What became of several entities, in their order."""

    results: tuple[Spawning, ...]


class EntityName(Message):
    """An entity by name."""

    name: str


class Entities(Message):
    """Names of entities, sorted."""

    names: tuple[str, ...]


class SetEntityState(Message):
    """Put an entity somewhere; None leaves that part as it is."""

    name: str
    pose: Pose | None = None
    twist: Twist | None = None


MODEL = Limits(5 * MEBIBYTE)  # the text of a model, of which nodes read a million characters
MODELS = Limits(ANSWER.size, 100_000)  # several hundred entities

SPAWN_ENTITY = Verb("spawn_entity", SpawnEntity, EntityName, MODEL)
SPAWN_ENTITIES = Verb("spawn_entities", SpawnEntities, Spawnings, MODELS)
DELETE_ENTITY = Verb("delete_entity", EntityName, Empty)
GET_ENTITIES = Verb("get_entities", EntityFilter, Entities)
GET_ENTITY_STATE = Verb("get_entity_state", EntityName, EntityState)
SET_ENTITY_STATE = Verb("set_entity_state", SetEntityState, Empty)
