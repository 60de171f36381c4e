"""Entities of a world by name: robots, walls, props and cameras of its file, and spawned ones."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from seoro.bridges.wire import Category, WorldResult
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.deferred import dataclass
from sim_nodes.agents.agent import Agent
from sim_nodes.buildings.parts import Lift, initial_state
from sim_nodes.cameras import Cameras
from sim_nodes.extents import BoundingBox, bounding_box
from sim_nodes.outcomes import feature_unsupported, operation_failed, unknown
from sim_nodes.physics import BodyModel, BodyState, DrivesBodies, Engine
from sim_nodes.robots.moving_links import parts_of_robot
from sim_nodes.spawning import Spawned
from sim_nodes.stateful import Stateful
from sim_nodes.terrain.ground import Ground
from sim_nodes.terrain.placing import lift_onto, raised
from sim_nodes.worlds.loader import World
from sim_nodes.worlds.props import check_start_poses

NO_AGENTS: Mapping[str, Agent] = MappingProxyType({})


@dataclass(frozen=True)
class EntityInfo:
    """Description and tags of an entity."""

    category: Category
    description: str
    tags: tuple[str, ...] = ()


class KnownEntities(Stateful):
    """The entities of a world, by name.

    Args:
        engine: Engine that has the entities.
        world: The world.
        seed: Seed of the simulation.
        agents: People and carts of the world.

    Raises:
        RequestRefused: A robot, a person, a cart, a door, a lift or a movable prop overlaps something.

    Attributes:
        built_in: Bodies of doors and lifts by name, which are the first driven bodies in the engine.
        lifts: Names of the lifts.
        agents: People and carts by name, also spawned ones, in the order of their bodies in the engine.
        spawned: Spawned bodies by name, in order.
        cameras: All cameras; the free ones are entities.
    """

    STATE = ("agents", "spawned", "cameras", "_infos")

    def __init__(self, engine: Engine, world: World, seed: int, agents: Mapping[str, Agent] = NO_AGENTS) -> None:
        self._engine = engine
        self._world = world
        self._robots = {robot.name: robot for robot in world.robots}
        self._walls = frozenset(wall.name for wall in world.walls)
        self._props = {prop.name: prop.model for prop in world.props}
        self.built_in = {name: model for part in world.building for name, model in part.bodies}
        self.lifts = frozenset(part.name for part in world.building if isinstance(part, Lift))
        self.agents = dict(agents)
        self._add_props(world)
        check_start_poses(engine, world.name, world.robots)
        own = self._robots.keys() | self._walls | self._props.keys()
        self._of_world = own | self.built_in.keys() | agents.keys()
        self.spawned: dict[str, Spawned] = {}
        self._infos: dict[str, EntityInfo] = {}  # set by clients
        self.cameras = Cameras(engine, world, seed)

    def _add_props(self, world: World) -> None:
        if (moving := [*self.built_in, *self.agents]) and not isinstance(self._engine, DrivesBodies):
            raise feature_unsupported(
                f"the engine {self._engine.name} does not move doors, lifts, people and carts; the world "
                f"{world.name} has {name_list(moving)}"
            )
        built_in = [
            (name, model, initial_state(place))
            for part in world.building
            for (name, model), place in zip(part.bodies, part.places(part.start), strict=True)
        ]
        agents = [
            (name, agent.model, raised(agent.state, lift_onto(world.ground, agent.model, agent.state)))
            for name, agent in self.agents.items()
        ]
        props = [(prop.name, prop.model, prop.state) for prop in world.props]
        for name, model, state in (*props, *built_in, *agents):
            self._engine.add_body(name, model, state)
        checked = [("prop", prop.name, prop.state) for prop in world.props if not prop.model.static]
        for kind, name, state in (*checked, *(("person or cart", name, state) for name, _, state in agents)):
            if overlapping := self._engine.overlaps(name):
                raise RequestRefused(
                    WorldResult.RESOURCE_PARSE_ERROR,
                    f"{world.name}: the {kind} {placed(name, state)} overlaps {name_list(overlapping)}",
                )
        for name, _, state in built_in:
            others = set(self._engine.overlaps(name)) - self._walls - self.built_in.keys()
            if others:
                raise RequestRefused(
                    WorldResult.RESOURCE_PARSE_ERROR,
                    f"{world.name}: the {self.kind_of_part(name)} {placed(name, state)} "
                    f"overlaps {name_list(others)}",
                )

    def kind_of_part(self, name: str) -> str:
        """Return the kind of a part of the building: `door` or `lift`."""
        return "lift" if name in self.lifts else "door"

    @property
    def ground(self) -> Ground:
        """The ground of the world."""
        return self._world.ground

    def start_run(self) -> None:
        """Start a run with the present entities."""
        self.spawned = {name: replace(body, time=0.0) for name, body in self.spawned.items()}

    @property
    def bodies(self) -> Mapping[str, BodyModel]:
        """Props, doors, lifts, people, carts and spawned bodies by name."""
        agents = {name: agent.model for name, agent in self.agents.items()}
        spawned = {name: spawned.model for name, spawned in self.spawned.items()}
        return {**self._props, **self.built_in, **agents, **spawned}

    def info(self, name: str) -> EntityInfo:
        """Return the description and tags of an entity: those last set, or the initial ones."""
        self._check_known(name)
        return self._infos.get(name) or self._initial_info(name)

    def set_info(self, name: str, info: EntityInfo) -> None:
        """Set the description and tags of an entity, until it is deleted or everything is reset."""
        self._check_known(name)
        self._infos[name] = info

    def _initial_info(self, name: str) -> EntityInfo:
        tags = self._world.entity_tags.get(name, ())
        if name in self._robots:
            return EntityInfo(Category.ROBOT, "a robot of the world", tags)
        if name in self._walls:
            return EntityInfo(Category.STATIC_OBJECT, "walls of the world", tags)
        if name in self.cameras.free:
            return EntityInfo(Category.OBJECT, "a camera", tags)
        agent = self.agents.get(name)
        if agent is not None:
            category = Category.HUMAN if agent.is_person else Category.DYNAMIC_OBJECT
            return EntityInfo(category, "a person" if agent.is_person else "a cart", agent.tags)
        if name in self.built_in:
            return EntityInfo(Category.DYNAMIC_OBJECT, f"a {self.kind_of_part(name)}", tags)
        category = Category.STATIC_OBJECT if self.bodies[name].static else Category.DYNAMIC_OBJECT
        if name in self._props:
            return EntityInfo(category, "a prop of the world", tags)
        spawned = self.spawned[name]
        return EntityInfo(category, f"spawned at {spawned.time:.3f} s", spawned.tags)

    def bounds(self, name: str) -> BoundingBox | None:
        """Return the bounds of an entity in its own frame; None without a shape, as for a camera."""
        self._check_known(name)
        if name in self.cameras.free:
            return None
        if name in self._robots:
            state = self._engine.body_state(name)
            return bounding_box(parts_of_robot(self._engine, self._robots[name], state))
        if name in self._walls:
            return bounding_box(wall.part for wall in self._world.walls if wall.name == name)
        return bounding_box(self.bodies[name].parts)

    def names(self) -> tuple[str, ...]:
        """Return the names of all entities, sorted."""
        return tuple(sorted(self._of_world | self.cameras.free | self.spawned.keys()))

    def movable(self) -> dict[str, float]:
        """Return the movable bodies, with the times at which they were spawned [s]; 0 for props."""
        props = {name: 0.0 for name, model in self._props.items() if not model.static}
        props |= dict.fromkeys((*self.built_in, *self.agents), 0.0)
        return props | {name: body.time for name, body in self.spawned.items() if not body.model.static}

    def is_movable(self, name: str) -> bool:
        """Whether an entity is a movable body."""
        return name in self.movable()

    def matching(self, pattern: str) -> tuple[str, ...]:
        """Return the names that fully match a regular expression, sorted; all names if it is empty.

        Raises:
            RequestRefused: The expression is invalid.
        """
        if len(pattern) > 200:
            raise operation_failed("the filter has more than 200 characters")
        try:
            expression = re.compile(pattern)
        except re.error as error:
            raise operation_failed(f"invalid regular expression {pattern!r} as filter: {error}") from error
        return tuple(name for name in self.names() if not pattern or expression.fullmatch(name))

    def state(self, name: str) -> BodyState:
        """Return the state of an entity; walls are at the origin."""
        self._check_known(name)
        if name in self.cameras.free:
            view = self.cameras.view(name)
            return BodyState(view.position, view.orientation)
        return BodyState((0.0, 0.0, 0.0)) if name in self._walls else self._engine.body_state(name)

    def is_known(self, name: str) -> bool:
        """Whether there is an entity of a name."""
        return name in self._of_world or name in self.spawned or name in self.cameras.free

    def _check_known(self, name: str) -> None:
        if not self.is_known(name):
            raise unknown(f"entity {name!r}", "entities", self.names())


def placed(name: str, state: BodyState) -> str:
    """Return a name with a place, for messages."""
    x, y, _ = state.position
    return f"{name!r} at ({x:.2f}, {y:.2f})"
