"""The people and carts of a simulation: goals, and velocities in each tick."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from seoro.bridges.wire import Avoidance, Outcome
from seoro.deferred import dataclass
from sim_nodes.agents import orca, social_force
from sim_nodes.agents.agent import HOVER, Agent, Motion, Point, Stand, Wander
from sim_nodes.agents.drawing import path_of
from sim_nodes.agents.motions import PATIENCE, RETRY_TICKS, Task, advance, choose_target, wanted_velocity
from sim_nodes.agents.neighbourhood import Neighbourhood
from sim_nodes.agents.stopping import stop_before_others, stop_before_walls, without_blocked
from sim_nodes.agents.walls import Walls
from sim_nodes.entities import Entities
from sim_nodes.geometry import Array, wrap
from sim_nodes.noise import Noise
from sim_nodes.outcomes import GoalResult, incorrect_state, operation_failed, unknown
from sim_nodes.physics import Engine
from sim_nodes.stateful import Stateful
from sim_nodes.terrain.placing import tops
from sim_nodes.ticks import TICK

ACCELERATION = 5.0  # [m/s^2] maximum
TURN_TIME, TURN_RATE = 0.2, 4.0  # [s] to turn into the direction of walking; [rad/s] maximum
WALKING = 0.05  # [m/s] from which an agent turns
PAUSE_TICKS = 250  # that an agent with `NONE` stands after it was blocked

Pair = tuple[str, str]


@dataclass(frozen=True)
class Traits:
    """Arrays of what agents keep.

    Attributes:
        agents: The agents.
        radii: Their radii, shape (n,) [m].
        avoids: Mask of the agents with each way to avoid others, shape (n,).
    """

    agents: tuple[Agent, ...]
    radii: Array
    avoids: Mapping[Avoidance, NDArray[np.bool_]]

    @staticmethod
    def of(agents: tuple[Agent, ...]) -> Traits:
        """Return the traits of agents."""
        ways = {way: np.array([agent.avoid is way for agent in agents], dtype=np.bool_) for way in Avoidance}
        return Traits(agents, np.array([agent.radius for agent in agents]), ways)


class Agents(Stateful):
    """The agents of a simulation.

    Args:
        engine: Engine with their bodies.
        entities: Entities of the world, among them the agents.
        robots: Radii of robots by name [m].
        walls: Walls of the world.
        seed: Seed of the simulation.
    """

    STATE = ("_tasks", "_velocities", "_paused")
    DERIVED = ("_traits",)

    def __init__(
        self, engine: Engine, entities: Entities, robots: Mapping[str, float], walls: Walls, seed: int
    ) -> None:
        self._engine, self._entities, self._robots = engine, entities, robots
        self._walls, self._seed = walls, seed
        self._tasks = {name: Task(agent.motion) for name, agent in entities.agents.items()}
        self._velocities: dict[str, Point] = dict.fromkeys(self._tasks, (0.0, 0.0))  # commanded last [m/s]
        self._paused: dict[str, int] = {}  # ticks until which agents stand
        self._traits = Traits.of(())

    def __bool__(self) -> bool:
        return bool(self._entities.agents)

    # ------------------------------------------------------------ goals

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of active goals that a client waits for."""
        return tuple(task.goal for task in self._tasks.values() if task.goal is not None)

    def agent(self, name: str) -> Agent:
        """Return an agent by name.

        Raises:
            RequestRefused: It is unknown.
        """
        if name not in self._entities.agents:
            raise unknown(f"person {name!r}", "people and carts", self._entities.agents)
        return self._entities.agents[name]

    def start(self, name: str, motion: Motion, goal: str, tick: int) -> None:
        """Start a motion of an agent, whose result is reported.

        Raises:
            RequestRefused: The agent is unknown or busy, or its way leads through a wall.
        """
        agent = self.agent(name)
        task = self._tasks.get(name)
        if task is not None and task.goal is not None:
            raise incorrect_state(f"{name} is busy with goal {task.goal!r}; cancel it or wait for its end")
        here = self._engine.body_state(name).planar
        problem = self._walls.describe_block(path_of(motion, (here.x, here.y)), agent.radius)
        if problem:
            raise operation_failed(problem)
        self._tasks[name] = Task(motion, goal, since=tick)

    def stop(self, name: str) -> Iterator[GoalResult]:
        """Make an agent stand; yields the result of its cancelled goal."""
        self.agent(name)
        task = self._tasks.get(name, Task(Stand()))
        self._tasks[name] = Task(Stand())
        if task.goal is not None:
            yield GoalResult(task.goal, Outcome.CANCELED)

    def cancel(self, goal: str) -> Iterator[GoalResult]:
        """Cancel a goal by id; yields its result."""
        for name in [name for name, task in self._tasks.items() if task.goal == goal]:
            yield from self.stop(name)

    def detach_goals(self, goals: Container[str]) -> None:
        """Continue some goals without their client: their results are not reported."""
        for name, task in self._tasks.items():
            if task.goal is not None and task.goal in goals:
                self._tasks[name] = replace(task, goal=None)

    # ------------------------------------------------------------ ticks

    def tick(self, tick: int, touching: Set[Pair], poses: Array) -> Iterator[GoalResult]:
        """Choose the velocities until the next tick; yields the results of goals that ended.

        Args:
            tick: The present tick.
            touching: Pairs of entities in contact.
            poses: Poses of the agents: x, y [m] and yaw [rad], shape (n, 3).
        """
        yield from self._drop_deleted()
        if not self:
            return
        names = tuple(self._entities.agents)
        places: list[Point] = [(x, y) for x, y, _ in poses.tolist()]
        for name, place in zip(names, places, strict=True):
            yield from self._progress(name, place, tick)
        wanted = np.array([self._wanted(name, place) for name, place in zip(names, places, strict=True)])
        velocities = self._avoid(names, poses[:, :2], wanted)
        self._stop_at_contacts(names, velocities, touching, tick)
        self._velocities = {name: (vx, vy) for name, (vx, vy) in zip(names, velocities.tolist(), strict=True)}

    def motion(self, poses: Array) -> tuple[Array, Array]:
        """Return velocities and heights of the agents, the arguments of `DrivesBodies.drive_bodies`.

        Args:
            poses: See `tick`.
        """
        velocities = np.array([self._velocities[name] for name in self._entities.agents]).reshape(-1, 2)
        turns = _turn_rates(velocities, poses[:, 2])
        heights = np.full(len(poses), HOVER)
        if not (ground := self._entities.ground).is_flat:
            heights += tops(ground, poses[:, :2], self._traits.radii)
        return np.column_stack([velocities, turns]), heights

    def _drop_deleted(self) -> Iterator[GoalResult]:
        """Forget deleted agents; yields the results of their goals."""
        for name in self._tasks.keys() - self._entities.agents.keys():
            task = self._tasks.pop(name)
            self._velocities.pop(name, None)
            self._paused.pop(name, None)
            if task.goal is not None:
                yield GoalResult(task.goal, Outcome.ABORTED, f"{name} was deleted")

    def _progress(self, name: str, place: Point, tick: int) -> Iterator[GoalResult]:
        """Update the motion of an agent at a place; yields the result of a goal that ended."""
        task = self._tasks.get(name, Task(Stand()))
        motion = advance(task.motion, place)
        if isinstance(motion, Wander) and motion.target is None and tick % RETRY_TICKS == 0:
            noise = Noise(self._seed, f"{name}/wander")
            motion = choose_target(motion, self.agent(name), place, self._walls, noise, tick)
        if motion is not task.motion:
            task = replace(task, motion=motion)
        if (goal := task.goal) is None:
            self._tasks[name] = task
            return
        task = task.track(place, tick)
        ended: GoalResult | None = None
        if isinstance(motion, Stand):
            ended = GoalResult(goal, Outcome.SUCCEEDED)
        elif task.can_be_blocked and tick - task.since > PATIENCE:
            x, y = place
            ended = GoalResult(
                goal,
                Outcome.ABORTED,
                f"{name} is blocked at ({x:.2f}, {y:.2f}): no progress in {PATIENCE * TICK:g} s",
            )
        self._tasks[name] = task if ended is None else Task(Stand())
        if ended is not None:
            yield ended

    def _wanted(self, name: str, place: Point) -> Point:
        return wanted_velocity(self._tasks[name].motion, place, self._position)

    def _position(self, entity: str) -> Point | None:
        """Return the position of a robot or body [m]; None if it is gone."""
        if entity not in self._robots and entity not in self._entities.bodies:
            return None
        x, y, _ = self._engine.body_state(entity).position
        return x, y

    # ------------------------------------------------------------ velocities

    def _avoid(self, names: Sequence[str], places: Array, wanted: Array) -> Array:
        """Return the velocities by the model of each agent, limited in acceleration and before walls."""
        agents = tuple(self._entities.agents.values())
        if self._traits.agents != agents:
            self._traits = Traits.of(agents)
        around = self._neighbourhood(names, places)
        velocities, walks = wanted.copy(), wanted.any(axis=1)
        for avoidance, model in MODELS.items():
            chosen = walks & self._traits.avoids[avoidance]
            if chosen.any():
                velocities[chosen] = model(around.of(chosen), wanted[chosen], TICK)
        velocities = _limited(around.velocities, velocities)
        careful = ~self._traits.avoids[Avoidance.NONE]
        if careful.any():
            velocities[careful] = stop_before_others(around.of(careful), velocities[careful])
        return stop_before_walls(around, velocities)

    def _stop_at_contacts(self, names: Sequence[str], velocities: Array, touching: Set[Pair], tick: int) -> None:
        """Stop agents at contacts, in place; those with `NONE` stand for a while then."""
        met = {name for pair in touching for name in pair}
        for index, name in enumerate(names):
            if name in met:
                free = without_blocked(velocities[index], self._engine.contact_points(name))
                is_blocked = not np.array_equal(free, velocities[index])
                velocities[index] = free
                if is_blocked and self._entities.agents[name].avoid is Avoidance.NONE:
                    self._paused[name] = tick + PAUSE_TICKS
            if tick < self._paused.get(name, 0):
                velocities[index] = 0.0

    def _neighbourhood(self, names: Sequence[str], places: Array) -> Neighbourhood:
        robots = [self._engine.body_state(name) for name in self._robots]
        velocities = np.array([self._velocities.get(name, (0.0, 0.0)) for name in names])
        radii = self._traits.radii
        distances, away = self._walls.nearest(places)
        count = len(names)
        return Neighbourhood(
            places,
            velocities,
            radii,
            distances,
            away,
            np.vstack([places, np.array([robot.position[:2] for robot in robots]).reshape(-1, 2)]),
            np.vstack([velocities, np.array([robot.linear[:2] for robot in robots]).reshape(-1, 2)]),
            np.concatenate([radii, np.array(tuple(self._robots.values()))]),
            np.eye(count, count + len(robots), dtype=np.bool_),
        )


MODELS: Mapping[Avoidance, Callable[[Neighbourhood, Array, float], Array]] = MappingProxyType(
    {Avoidance.SOCIAL_FORCE: social_force.velocities_after, Avoidance.ORCA: orca.velocities_after}
)
"""Models that avoid others: functions of the neighbourhood, wanted velocities and the duration of a tick."""


def _limited(before: Array, after: Array) -> Array:
    """Return velocities of shape (n, 2) after a tick with a limited acceleration [m/s]."""
    change = after - before
    size = np.hypot(change[:, 0], change[:, 1])
    limited: Array = before + change * (ACCELERATION * TICK / np.maximum(size, ACCELERATION * TICK))[:, None]
    return limited


def _turn_rates(velocities: Array, yaws: Array) -> Array:
    """Return the yaw rates that turn agents into their direction of motion, shape (n,) [rad/s]."""
    turn = wrap(np.arctan2(velocities[:, 1], velocities[:, 0]) - yaws) / TURN_TIME
    walks = np.hypot(velocities[:, 0], velocities[:, 1]) > WALKING
    rates: Array = np.where(walks, turn.clip(-TURN_RATE, TURN_RATE), 0.0)
    return rates
