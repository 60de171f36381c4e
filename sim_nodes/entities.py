"""Entities of a world by name: robots, walls, props and cameras of its file, and spawned ones."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from seoro.bridges.wire import Category, SpawnResult, WorldResult
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.deferred import dataclass
from sim_nodes.agents.agent import Agent
from sim_nodes.buildings.parts import Lift, initial_state
from sim_nodes.cameras import Cameras
from sim_nodes.departures import is_within
from sim_nodes.extents import FLOOR_TOLERANCE, BoundingBox, bounding_box, lowest_point
from sim_nodes.files import NAME
from sim_nodes.geometry import Vector
from sim_nodes.models.scenes import SceneBody
from sim_nodes.outcomes import feature_unsupported, operation_failed, unknown
from sim_nodes.physics import BodyModel, BodyState, DrivesBodies, Engine, ManyBodies
from sim_nodes.robots.urdf_check import parts_of_robot
from sim_nodes.spawning import Spawned, SpawnRequest, first_free, placed_bodies
from sim_nodes.stateful import Stateful
from sim_nodes.terrain.ground import Ground
from sim_nodes.terrain.placing import lift_onto, raised, standing
from sim_nodes.views import Lens
from sim_nodes.worlds.loader import World
from sim_nodes.worlds.props import check_start_poses

MAX_SPAWNED = 1000
NO_AGENTS: Mapping[str, Agent] = MappingProxyType({})
RESERVED = frozenset({"floor", "map", "odom", "base_link", "world"})


@dataclass(frozen=True)
class EntityInfo:
    """Description and tags of an entity."""

    category: Category
    description: str
    tags: tuple[str, ...] = ()


class Entities(Stateful):
    """The entities of a world.

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
                    f"{world.name}: the {kind} {_at(name, state)} overlaps {name_list(overlapping)}",
                )
        for name, _, state in built_in:
            others = set(self._engine.overlaps(name)) - self._walls - self.built_in.keys()
            if others:
                raise RequestRefused(
                    WorldResult.RESOURCE_PARSE_ERROR,
                    f"{world.name}: the {self.kind_of_part(name)} {_at(name, state)} overlaps {name_list(others)}",
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

    def spawn(self, request: SpawnRequest, time: float) -> str:
        """Spawn a body; returns its name, which may differ from the requested one with `rename`.

        Raises:
            RequestRefused: The name is in use or invalid, or the body would overlap something.
        """
        [result] = self.spawn_all([request], time)
        if isinstance(result, RequestRefused):
            raise result
        return result

    def spawn_all(self, requests: Sequence[SpawnRequest], time: float) -> list[str | RequestRefused]:
        """Spawn bodies in order, each as if the earlier ones existed; returns names or refusals."""
        results: list[str | RequestRefused] = []
        added: list[tuple[str, BodyModel, BodyState]] = []
        for request in requests:
            try:
                bodies = self._accept(request, time)
            except RequestRefused as refused:
                results.append(refused)
            else:
                results.append(next(iter(bodies)))
                added += [(name, model, state) for name, (model, state) in bodies.items()]
        if added:
            self._add(added)
        self._remove_overlapping(results, requests)
        return results

    def _accept(self, request: SpawnRequest, time: float) -> dict[str, tuple[BodyModel, BodyState]]:
        """Check and register bodies without the engine; returns them by name, the one of the request first."""
        name = self._free_name(request.name, request.rename)
        if len(self.spawned) + len(request.bodies) > MAX_SPAWNED:
            raise operation_failed(f"too many spawned entities: {MAX_SPAWNED} at most; delete some")
        bodies = placed_bodies(name, request.bodies, request.state, self.names())
        for each, (model, state) in bodies.items():
            _check_floor(each, model, state)
        ground = self._world.ground
        lift = max(lift_onto(ground, model, state) for model, state in bodies.values())
        bodies = {each: (model, raised(state, lift)) for each, (model, state) in bodies.items()}
        for each, (model, _) in bodies.items():
            self.spawned[each] = Spawned(model, time, request.tags, "" if each == name else name)
        return bodies

    def scene_of(self, name: str) -> tuple[str, ...]:
        """Return the names of a spawned body and of the others in its file, if it is the first of them."""
        return (name, *(each for each, body in self.spawned.items() if body.scene == name))

    def _remove_overlapping(self, results: list[str | RequestRefused], requests: Sequence[SpawnRequest]) -> None:
        """Remove bodies that overlap entities or earlier bodies, and the others in their files."""
        later = {each for name in results if isinstance(name, str) for each in self.scene_of(name)}
        refused: list[str] = []
        for index, (name, request) in enumerate(zip(results, requests, strict=True)):
            if not isinstance(name, str):
                continue
            own = self.scene_of(name)
            ignored = later | set(refused) | set(own)
            found = {each: set(self._engine.overlaps(each)) - ignored for each in own}
            later -= set(own)
            overlapping = set().union(*found.values())
            if overlapping:
                what = next(each for each, others in found.items() if others)
                shown = _at(name, request.state) if what == name else repr(what)
                results[index] = RequestRefused(
                    SpawnResult.INVALID_POSE, f"{shown} would overlap {name_list(overlapping)}"
                )
                refused += own
        self._remove(refused)

    def _add(self, bodies: Sequence[tuple[str, BodyModel, BodyState]]) -> None:
        try:
            if isinstance(self._engine, ManyBodies):
                self._engine.add_bodies(bodies)
            else:
                for name, model, state in bodies:
                    self._engine.add_body(name, model, state)
        except BaseException:
            for name, _, _ in bodies:
                del self.spawned[name]
            raise

    def _remove(self, names: Sequence[str]) -> None:
        """Remove spawned bodies."""
        if not names:
            return
        if isinstance(self._engine, ManyBodies):
            self._engine.remove_bodies(names)
        else:
            for name in names:
                self._engine.remove_body(name)
        for name in names:
            del self.spawned[name]
            self.agents.pop(name, None)
            self._infos.pop(name, None)

    def spawn_camera(self, name: str, lens: Lens, place: BodyState) -> str:
        """Spawn a free camera; returns its name.

        Raises:
            RequestRefused: The name is in use or invalid, or there are too many cameras.
        """
        name = self._free_name(name, rename=False)
        self.cameras.add(name, lens, place)
        return name

    def follow(self, camera: str, entity: str, offset: Vector) -> None:
        """Make a free camera follow a robot or a body.

        Raises:
            RequestRefused: The camera or entity is unknown, or the entity never moves.
        """
        self._check_known(entity)
        if entity in self._walls | self.cameras.free:
            raise feature_unsupported(f"cameras follow robots and bodies; {entity!r} is neither")
        self.cameras.follow(camera, entity, offset)

    def spawn_agent(self, name: str, agent: Agent, time: float) -> None:
        """Spawn a person at its initial pose.

        Raises:
            RequestRefused: See `spawn`.
        """
        body = SceneBody("body", agent.model, BodyState((0.0, 0.0, 0.0)))
        self.spawn(SpawnRequest(name, (body,), agent.state, rename=False, tags=agent.tags), time)
        self.agents[name] = agent

    def _free_name(self, name: str, rename: bool) -> str:
        if not re.fullmatch(NAME, name) or name in RESERVED:
            raise RequestRefused(
                SpawnResult.NAME_INVALID,
                f"invalid name {name!r}; expected letters, digits, '_' and '-', a letter first, at most 64, "
                f"and not {name_list(RESERVED)}",
            )
        used = self.names()
        if name in used and not rename:
            raise RequestRefused(
                SpawnResult.NAME_NOT_UNIQUE, f"duplicate name {name!r} of an entity; in use: {name_list(used)}"
            )
        return first_free(name, used)

    def move(self, name: str, state: BodyState) -> None:
        """Set the state of a robot, prop, spawned body or free camera; one in terrain is put on it.

        Raises:
            RequestRefused: The entity is unknown or cannot move, or it would overlap something.
        """
        self._check_known(name)
        if name in self._walls:
            raise feature_unsupported(f"{name!r} cannot be moved: it is a wall of the world")
        if name in self.built_in:
            kind = self.kind_of_part(name)
            raise feature_unsupported(f"{name!r} cannot be placed: it is a {kind}; move it by `move_{kind}`")
        if name in self._robots and self._robots[name].declaration.fixed:
            raise feature_unsupported(f"{name!r} cannot be moved: it is fixed to the world")
        if name in self.cameras.free:
            self.cameras.set_mount(name, state)
            return
        if name in self.bodies:
            _check_floor(name, self.bodies[name], state)
            state = raised(state, lift_onto(self._world.ground, self.bodies[name], state))
        elif not is_within(state.position, self._world.extent):
            raise operation_failed(f"{_at(name, state)} would be outside of the world")
        else:
            state = standing(self._world.ground, self._robots[name].declaration, state)
        before = self._engine.body_state(name)
        self._engine.set_body_state(name, state)
        overlapping = self._engine.overlaps(name)
        if overlapping and state.position != before.position:
            self._engine.set_body_state(name, before)
            raise operation_failed(f"{_at(name, state)} would overlap {name_list(overlapping)}")

    def delete(self, name: str) -> None:
        """Delete a spawned entity; with the first body of a file, the others of the file are deleted.

        Raises:
            RequestRefused: The entity was not spawned.
        """
        self._check_known(name)
        if name in self.cameras.free:
            self.cameras.remove(name)
            self._infos.pop(name, None)
            return
        if name not in self.spawned:
            raise operation_failed(
                f"{name!r} belongs to the world; only spawned entities can be deleted: {name_list(self.spawned)}"
            )
        names = self.scene_of(name)
        for each in names:
            self.cameras.unfollow(each)
        self._remove(names)

    def delete_all(self) -> None:
        """Delete all spawned entities."""
        for name in self.spawned:
            self.cameras.unfollow(name)
        self._remove(tuple(self.spawned))
        self.cameras.remove_spawned()
        self._infos = {name: info for name, info in self._infos.items() if name in self.names()}

    def is_known(self, name: str) -> bool:
        """Whether there is an entity of a name."""
        return name in self._of_world or name in self.spawned or name in self.cameras.free

    def _check_known(self, name: str) -> None:
        if not self.is_known(name):
            raise unknown(f"entity {name!r}", "entities", self.names())


def _at(name: str, state: BodyState) -> str:
    x, y, _ = state.position
    return f"{name!r} at ({x:.2f}, {y:.2f})"


def _check_floor(name: str, model: BodyModel, state: BodyState) -> None:
    lowest = lowest_point(model, state)
    if lowest < -FLOOR_TOLERANCE:
        needed = state.position[2] - lowest
        raise RequestRefused(
            SpawnResult.INVALID_POSE,
            f"{_at(name, state)} would be {-lowest:.3f} m below the floor; expected z of {needed:.3f} m or more",
        )
