"""What is in a world by name: robots, walls and cameras of its file, and what is spawned, moved and deleted."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from seoro.bridges.wire import Category, Result, SpawnResult, WorldResult
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.bounds import BoundingBox, bounding_box, parts_of_robot
from sim_nodes.cameras import Cameras
from sim_nodes.departures import is_within
from sim_nodes.extents import FLOOR_TOLERANCE, lowest_point
from sim_nodes.files import NAME
from sim_nodes.geometry import Vector
from sim_nodes.physics import BodyModel, BodyState, Engine, ManyBodies
from sim_nodes.starts import check_starts
from sim_nodes.stateful import Stateful
from sim_nodes.views import Lens
from sim_nodes.worlds.loader import World

MAX_SPAWNED = 1000
RESERVED = frozenset({"floor", "map", "odom", "base_link", "world"})


@dataclass(frozen=True)
class Spawned:
    """A body that was spawned."""

    model: BodyModel
    time: float  # [s]
    tags: tuple[str, ...] = ()


@dataclass(frozen=True)
class Info:
    """What is said of an entity: for people, and by which tags it is found."""

    category: Category
    description: str
    tags: tuple[str, ...] = ()


@dataclass(frozen=True)
class Wish:
    """A body that is to be spawned; under another name if its own is taken, with `rename`."""

    name: str
    model: BodyModel
    state: BodyState
    rename: bool
    tags: tuple[str, ...] = ()


class Entities(Stateful):
    """The entities of a world.

    Args:
        engine: The engine that they are in.
        world: The world.
        seed: Seed of the simulation.

    Raises:
        RequestRefused: A robot, or a prop that can move, overlaps something.

    Attributes:
        spawned: The bodies that were spawned, by name, in order.
        cameras: All cameras, of which the free ones are entities.
    """

    STATE = ("spawned", "cameras", "_told")

    def __init__(self, engine: Engine, world: World, seed: int) -> None:
        self._engine = engine
        self._world = world
        self._robots = frozenset(robot.name for robot in world.robots)
        self._fixed = frozenset(robot.name for robot in world.robots if robot.declaration.fixed)
        self._walls = frozenset(wall.name for wall in world.walls)
        self._props = {prop.name: prop.model for prop in world.props}
        self._add_props(world)
        check_starts(engine, world)
        self._of_the_world = self._robots | self._walls | self._props.keys()
        self.spawned: dict[str, Spawned] = {}
        self._told: dict[str, Info] = {}  # what somebody has said of entities
        self.cameras = Cameras(engine, world, seed)

    def _add_props(self, world: World) -> None:
        for prop in world.props:
            self._engine.add_body(prop.name, prop.model, prop.state)
        for prop in world.props:
            in_the_way = () if prop.model.static else self._engine.overlaps(prop.name)
            if in_the_way:
                raise RequestRefused(
                    WorldResult.RESOURCE_PARSE_ERROR,
                    f"{world.name}: the prop {_at(prop.name, prop.state)} overlaps {listed(in_the_way)}",
                )

    def begin(self) -> None:
        """A run begins with what is there."""
        self.spawned = {name: replace(body, time=0.0) for name, body in self.spawned.items()}

    @property
    def bodies(self) -> Mapping[str, BodyModel]:
        """Props and what was spawned, by name."""
        return {**self._props, **{name: spawned.model for name, spawned in self.spawned.items()}}

    def info(self, name: str) -> Info:
        """What an entity is: what was said of it last, or what it is by itself."""
        self._known(name)
        if name in self._told:
            return self._told[name]
        tags = self.spawned[name].tags if name in self.spawned else self._world.entity_tags.get(name, ())
        return Info(self._category(name), self._description(name), tags)

    def tell(self, name: str, info: Info) -> None:
        """Say what an entity is, until it is deleted, or everything is reset."""
        self._known(name)
        self._told[name] = info

    def _category(self, name: str) -> Category:
        if name in self._robots:
            return Category.ROBOT
        if name in self.cameras.free:
            return Category.OBJECT
        is_static = name in self._walls or self.bodies[name].static
        return Category.STATIC_OBJECT if is_static else Category.DYNAMIC_OBJECT

    def bounds(self, name: str) -> BoundingBox | None:
        """How far an entity reaches, in its own frame; None for what has no shape, such as a camera."""
        self._known(name)
        if name in self.cameras.free:
            return None
        if name in self._robots:
            placed = next(robot for robot in self._world.robots if robot.name == name)
            return bounding_box(parts_of_robot(self._engine, placed, self._engine.body_state(name)))
        if name in self._walls:
            return bounding_box(wall.part for wall in self._world.walls if wall.name == name)
        return bounding_box(self.bodies[name].parts)

    def _description(self, name: str) -> str:
        if name in self._robots:
            return "a robot of the world"
        if name in self._walls:
            return "walls of the world"
        if name in self.cameras.free:
            return "a camera"
        if name in self._props:
            return "a prop of the world"
        return f"spawned at {self.spawned[name].time:.3f} s"

    def names(self) -> tuple[str, ...]:
        """Names of all entities, sorted."""
        return tuple(sorted(self._of_the_world | self.cameras.free | self.spawned.keys()))

    def movable(self) -> dict[str, float]:
        """The bodies that something may push or carry, with the times at which they came into the world [s]."""
        props = {name: 0.0 for name, model in self._props.items() if not model.static}
        return props | {name: body.time for name, body in self.spawned.items() if not body.model.static}

    def is_loose(self, name: str) -> bool:
        """Whether it is a body that something may push or carry."""
        return name in self.movable()

    def matching(self, pattern: str) -> tuple[str, ...]:
        """Names that match a regular expression as a whole, sorted; all names do if it is empty.

        Raises:
            RequestRefused: It is no regular expression.
        """
        if len(pattern) > 200:
            raise RequestRefused(Result.OPERATION_FAILED, "the filter is longer than 200 characters")
        try:
            expression = re.compile(pattern)
        except re.error as error:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"the filter {pattern!r} is no regular expression: {error}"
            ) from error
        return tuple(name for name in self.names() if not pattern or expression.fullmatch(name))

    def state(self, name: str) -> BodyState:
        """The state of an entity; walls are at the origin."""
        self._known(name)
        if name in self.cameras.free:
            view = self.cameras.view(name)
            return BodyState(view.position, view.orientation)
        return BodyState((0.0, 0.0, 0.0)) if name in self._walls else self._engine.body_state(name)

    def spawn(self, wish: Wish, time: float) -> str:
        """Add a body; returns its name, which is another than the one asked for when that is taken and `rename`.

        Raises:
            RequestRefused: The name is taken or wrong, or there is something at that place.
        """
        [result] = self.spawn_all([wish], time)
        if isinstance(result, RequestRefused):
            raise result
        return result

    def spawn_all(self, wishes: Sequence[Wish], time: float) -> list[str | RequestRefused]:
        """Add bodies, each as if those before it were there already; returns their names, or why there is none."""
        results: list[str | RequestRefused] = []
        for wish in wishes:
            try:
                results.append(self._accept(wish, time))
            except RequestRefused as refused:
                results.append(refused)
        added = [
            (name, wish.model, wish.state)
            for name, wish in zip(results, wishes, strict=True)
            if isinstance(name, str)
        ]
        if added:
            self._add(added)
        self._take_back(results, wishes)
        return results

    def _accept(self, wish: Wish, time: float) -> str:
        """Take a body down, as far as it can be told without the engine."""
        name = self._free_name(wish.name, wish.rename)
        if len(self.spawned) >= MAX_SPAWNED:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"there are {MAX_SPAWNED} spawned entities already: delete some"
            )
        _check_floor(name, wish.model, wish.state)
        self.spawned[name] = Spawned(wish.model, time, wish.tags)
        return name

    def _take_back(self, results: list[str | RequestRefused], wishes: Sequence[Wish]) -> None:
        """Remove bodies that overlap something that was there before them."""
        later = {name for name in results if isinstance(name, str)}
        refused: list[str] = []
        for index, (name, wish) in enumerate(zip(results, wishes, strict=True)):
            if not isinstance(name, str):
                continue
            in_the_way = set(self._engine.overlaps(name)) - later - set(refused)
            later.discard(name)
            if in_the_way:
                results[index] = RequestRefused(
                    SpawnResult.INVALID_POSE, f"{_at(name, wish.state)} would overlap {listed(in_the_way)}"
                )
                refused.append(name)
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
            self._told.pop(name, None)

    def spawn_camera(self, name: str, lens: Lens, place: BodyState) -> str:
        """Add a free camera; returns its name.

        Raises:
            RequestRefused: The name is taken or wrong, or there are too many.
        """
        name = self._free_name(name, rename=False)
        self.cameras.add(name, lens, place)
        return name

    def follow(self, camera: str, entity: str, offset: Vector) -> None:
        """Let a free camera go with a robot or a spawned body.

        Raises:
            RequestRefused: There is no such camera or entity, or it is one that never moves.
        """
        self._known(entity)
        if entity in self._walls | self.cameras.free:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"cameras follow robots and what is spawned; {entity!r} is neither",
            )
        self.cameras.follow(camera, entity, offset)

    def _free_name(self, name: str, rename: bool) -> str:
        if not re.fullmatch(NAME, name) or name in RESERVED:
            raise RequestRefused(
                SpawnResult.NAME_INVALID,
                f"{name!r} cannot name an entity: use letters, digits, '_' and '-', a letter first, at most 64, "
                f"and none of {listed(RESERVED)}",
            )
        taken = self.names()
        if name not in taken:
            return name
        if not rename:
            raise RequestRefused(
                SpawnResult.NAME_NOT_UNIQUE, f"there is an entity {name!r} already: taken are {listed(taken)}"
            )
        return next(new for i in range(1, MAX_SPAWNED + 2) if (new := f"{name[:58]}_{i}") not in taken)

    def move(self, name: str, state: BodyState) -> None:
        """Put a robot, a prop or a spawned body somewhere.

        Raises:
            RequestRefused: It is a wall, unknown, or there is something at that place.
        """
        self._known(name)
        if name in self._walls:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED, f"{name!r} belongs to the world: walls cannot be moved"
            )
        if name in self._fixed:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"{name!r} is fixed to the world: it cannot be moved")
        if name in self.cameras.free:
            self.cameras.place(name, state)
            return
        if name in self.bodies:
            _check_floor(name, self.bodies[name], state)
        elif not is_within(state.position, self._world.extent):
            raise RequestRefused(Result.OPERATION_FAILED, f"{_at(name, state)} would be outside of the world")
        before = self._engine.body_state(name)
        self._engine.set_body_state(name, state)
        in_the_way = self._engine.overlaps(name)
        if in_the_way and state.position != before.position:
            self._engine.set_body_state(name, before)
            raise RequestRefused(Result.OPERATION_FAILED, f"{_at(name, state)} would overlap {listed(in_the_way)}")

    def delete(self, name: str) -> None:
        """Remove a spawned body.

        Raises:
            RequestRefused: It was not spawned.
        """
        self._known(name)
        if name in self.cameras.free:
            self.cameras.remove(name)
            self._told.pop(name, None)
            return
        if name not in self.spawned:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"{name!r} belongs to the world: what was spawned can be deleted, which is {listed(self.spawned)}",
            )
        self.cameras.forget(name)
        self._remove([name])

    def delete_all(self) -> None:
        """Remove all that was spawned."""
        for name in self.spawned:
            self.cameras.forget(name)
        self._remove(tuple(self.spawned))
        self.cameras.remove_spawned()
        self._told = {name: info for name, info in self._told.items() if name in self.names()}

    def _known(self, name: str) -> None:
        if name not in self.names():
            raise RequestRefused(
                Result.NOT_FOUND, f"there is no entity {name!r}: known are {listed(self.names())}"
            )


def _at(name: str, state: BodyState) -> str:
    x, y, _ = state.position
    return f"{name!r} at ({x:.2f}, {y:.2f})"


def _check_floor(name: str, model: BodyModel, state: BodyState) -> None:
    lowest = lowest_point(model, state)
    if lowest < -FLOOR_TOLERANCE:
        needed = state.position[2] - lowest
        raise RequestRefused(
            SpawnResult.INVALID_POSE,
            f"{_at(name, state)} would be {-lowest:.3f} m inside the floor: z has to be {needed:.3f} m or more",
        )
