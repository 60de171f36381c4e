"""Entities of the world and their filters: spawn, find, move and delete entities."""

from __future__ import annotations

from enum import IntEnum

from seoro.bridges.wire.geometry import EntityState, Twist
from seoro.bridges.wire.limits import MAX_REQUEST, Limits
from seoro.bridges.wire.message import Empty, Message, Query, Verb
from seoro.bridges.wire.results import Result
from seoro.robotics.geometry import Pose3D, Position3D


class NamedFile(Message):
    """A file by its virtual path."""

    path: str
    data: bytes


class SpawnEntity(Message):
    """Spawn an entity from the text of its model, or from a model by `uri`.

    Without a text, the node searches `uri` among those of `get_spawnables`, then along its model path. With a
    text, `uri` is its name for people, and `files` has the files named in the text. Their virtual paths are
    relative to the model, or begin with `package/NAME/` or `model/NAME/`. `tags` select the entity in filters.
    """

    name: str
    uri: str
    resource_string: str = ""
    files: tuple[NamedFile, ...] = ()
    initial_pose: Pose3D
    allow_renaming: bool = False
    tags: tuple[str, ...] = ()


class SpawnEntities(Message):
    """Spawn several entities, one after the other."""

    entities: tuple[SpawnEntity, ...]


class Spawned(Message):
    """A spawned entity: its name, and warnings about parts of its model."""

    name: str
    warnings: tuple[str, ...] = ()


class SpawnOutcome(Message):
    """Result of spawning one of several entities: its name and warnings, or a result code and a reason."""

    name: str
    code: int = Result.OK
    message: str = ""
    warnings: tuple[str, ...] = ()


class SpawnOutcomes(Message):
    """Results of spawning several entities, in order."""

    results: tuple[SpawnOutcome, ...]


class EntityName(Message):
    """An entity by name."""

    name: str


class Entities(Message):
    """Names of entities, sorted."""

    names: tuple[str, ...]


class SetEntityState(Message):
    """Set the pose and velocity of an entity; None leaves a part unchanged."""

    name: str
    pose: Pose3D | None = None
    twist: Twist | None = None


class Category(IntEnum):
    """Categories of entities, by the numbers of `simulation_interfaces`."""

    OBJECT = 0
    ROBOT = 1
    HUMAN = 2
    DYNAMIC_OBJECT = 4
    STATIC_OBJECT = 5


class Bounds(Message):
    """Box along the axes of a frame, by two corners [m]."""

    lower: Position3D
    upper: Position3D


class FilterMode(IntEnum):
    """Number of tags that have to match, by the numbers of `simulation_interfaces`."""

    ANY = 0
    ALL = 1


class TagsFilter(Message):
    """Items with any or all of some tags; all items if `tags` is empty."""

    tags: tuple[str, ...] = ()
    filter_mode: int = FilterMode.ANY


class EntityFilter(Message):
    """Entities that match all fields.

    Attributes:
        filter: Regular expression for the whole name; any name if empty.
        categories: Accepted categories; any if empty.
        bounds: Box around their origins in the frame `map`; None for any position.
        tags: Filter of their tags.
    """

    filter: str = ""
    categories: tuple[int, ...] = ()
    bounds: Bounds | None = None
    tags: TagsFilter = TagsFilter()


MODEL = Limits(MAX_REQUEST)  # the text of a model, with meshes
MODELS = Limits(MAX_REQUEST, 100_000)  # several hundred entities

SPAWN_ENTITY = Verb("spawn_entity", SpawnEntity, Spawned, MODEL)
SPAWN_ENTITIES = Verb("spawn_entities", SpawnEntities, SpawnOutcomes, MODELS)
DELETE_ENTITY = Verb("delete_entity", EntityName, Empty)
GET_ENTITIES = Query("get_entities", EntityFilter, Entities)
GET_ENTITY_STATE = Query("get_entity_state", EntityName, EntityState)
SET_ENTITY_STATE = Verb("set_entity_state", SetEntityState, Empty)
