"""What there is: worlds, entities with what they are and where, and the transforms of frames."""

from __future__ import annotations

from seoro.bridges.wire.entities import EntityName
from seoro.bridges.wire.filters import Bounds, EntityFilter, TagsFilter
from seoro.bridges.wire.geometry import EntityState, Pose
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.simulator import SimulationState


class EntityStates(Message):
    """Entities by their names, sorted, with their states."""

    names: tuple[str, ...]
    states: tuple[EntityState, ...]


class EntityInfo(Message):
    """What an entity is; `description` is for people, tags are what it is found by."""

    category: int
    description: str
    tags: tuple[str, ...] = ()


class SetEntityInfo(Message):
    """Say what an entity is, in the place of all that was said of it."""

    name: str
    info: EntityInfo


class EntityBounds(Message):
    """How far an entity reaches, along its own axes, as its joints are now; None for what has no shape."""

    bounds: Bounds | None


class CurrentWorld(Message):
    """The world that is loaded: its name, and the name or path by which it was asked for.

    `source` is empty for the world of a snapshot.
    """

    name: str
    source: str
    description: str = ""
    tags: tuple[str, ...] = ()


class GetAvailableWorlds(Message):
    """Which worlds there are that have some tags.

    They come with the node, or lie in one of `sources`: folders on its machine, each by its path or as `file://PATH`.
    """

    tags: TagsFilter = TagsFilter()
    sources: tuple[str, ...] = ()


class WorldInfo(Message):
    """A world that can be loaded by its `source`, a name or a path, and what its file says of it."""

    source: str
    description: str
    tags: tuple[str, ...]


class AvailableWorlds(Message):
    """Worlds, by names or paths; `message` names sources that are none, and says where the list ends early."""

    names: tuple[str, ...]
    worlds: tuple[WorldInfo, ...] = ()
    message: str = ""


class CurrentState(Message):
    """Whether time passes, and the simulator's clock [s]."""

    state: SimulationState
    time: float


class Transform(Message):
    """The pose of a frame in `map`; None as long as it has none, because its robot is not localised."""

    frame: str
    pose: Pose | None


class Transforms(Message):
    """All frames. That of a robot in truth is called NAME_base_link_gt."""

    transforms: tuple[Transform, ...]


GET_ENTITIES_STATES = Verb("get_entities_states", EntityFilter, EntityStates)
GET_ENTITY_INFO = Verb("get_entity_info", EntityName, EntityInfo)
SET_ENTITY_INFO = Verb("set_entity_info", SetEntityInfo, Empty)
GET_ENTITY_BOUNDS = Verb("get_entity_bounds", EntityName, EntityBounds)
GET_CURRENT_WORLD = Verb("get_current_world", Empty, CurrentWorld)
GET_AVAILABLE_WORLDS = Verb("get_available_worlds", GetAvailableWorlds, AvailableWorlds)
GET_SIMULATION_STATE = Verb("get_simulation_state", Empty, CurrentState)
GET_TRANSFORMS = Verb("get_transforms", Empty, Transforms)
