"""Progress of the motions of agents: targets, arrivals, and goals that are blocked."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from seoro.deferred import dataclass
from sim_nodes.agents.agent import Agent, Follow, Motion, Point, Stand, Walk, Wander
from sim_nodes.agents.walls import Walls
from sim_nodes.noise import Noise
from sim_nodes.ticks import TICK

ARRIVED = 0.05  # [m] from the last point of a path
PASSED = 0.25  # [m] from another point
BRAKING = 1.5  # [m/s^2] before the last point
TRIES = 20  # random destinations in a tick
RETRY_TICKS = 25  # between tries to find a destination
PATIENCE = round(20.0 / TICK)  # ticks without progress after which a goal is aborted
PROGRESS = 0.1  # [m]


@dataclass(frozen=True)
class Task:
    """The present motion of an agent.

    Attributes:
        motion: The motion.
        goal: Id of its goal; None without a client that waits.
        nearest: Smallest distance to the end of the path so far [m].
        since: Tick of the last progress.
    """

    motion: Motion
    goal: str | None = None
    nearest: float = math.inf
    since: int = 0

    @property
    def can_be_blocked(self) -> bool:
        """Whether its goal ends without progress; motions without an end never give up."""
        return isinstance(self.motion, Walk) and not self.motion.repeat

    def track(self, position: Point, tick: int) -> Task:
        """Return the task with the progress at a position in a tick."""
        left = remaining(self.motion, position)
        if left < self.nearest - PROGRESS:
            return replace(self, nearest=left, since=tick)
        return self


def remaining(motion: Motion, position: Point) -> float:
    """Return the length of the rest of a path [m]; 0 for other motions."""
    if not isinstance(motion, Walk):
        return 0.0
    rest = (position, *motion.points[motion.index :])
    return sum(math.dist(a, b) for a, b in pairwise(rest))


def advance(motion: Motion, position: Point) -> Motion:
    """Return a motion at a position: the next point of a path, or standing at its end."""
    if isinstance(motion, Walk):
        is_last = motion.index == len(motion.points) - 1 and not motion.repeat
        if math.dist(position, motion.points[motion.index]) > (ARRIVED if is_last else PASSED):
            return motion
        return Stand() if is_last else replace(motion, index=(motion.index + 1) % len(motion.points))
    if isinstance(motion, Wander) and motion.target is not None and math.dist(position, motion.target) <= PASSED:
        return replace(motion, target=None)
    return motion


def choose_target(motion: Wander, agent: Agent, position: Point, walls: Walls, noise: Noise, tick: int) -> Wander:
    """Return a wandering with a new destination in sight; without one, it stays for a while."""
    left, bottom, right, top = motion.area
    draw = noise.at(tick).uniform((left, bottom), (right, top), (TRIES, 2))
    for x, y in draw.tolist():
        if walls.is_clear(position, (x, y), agent.radius):
            return replace(motion, target=(x, y))
    return motion


def wanted_velocity(motion: Motion, position: Point, pose_of: Callable[[str], Point | None]) -> Point:
    """Return the velocity towards the next point of a motion [m/s].

    Args:
        motion: The motion.
        position: Position of the agent [m].
        pose_of: Returns the position of an entity; None if it is gone.
    """
    match motion:
        case Walk(points=points, index=index, speed=speed):
            is_last = index == len(points) - 1 and not motion.repeat
            return _towards(position, points[index], speed, 0.0 if is_last else None)
        case Wander(target=(x, y), speed=speed):
            return _towards(position, (x, y), speed, None)
        case Follow(entity=entity, distance=distance, speed=speed):
            target = pose_of(entity)
            return (0.0, 0.0) if target is None else _towards(position, target, speed, distance)
        case _:
            return 0.0, 0.0


def _towards(position: Point, target: Point, speed: float, stop: float | None) -> Point:
    """Return the velocity towards a target; with `stop`, it brakes before that distance [m]."""
    dx, dy = target[0] - position[0], target[1] - position[1]
    distance = math.hypot(dx, dy)
    if stop is not None:
        left = max(0.0, distance - stop)
        speed = min(speed, math.sqrt(2.0 * BRAKING * left), left / TICK)
    scale = speed / distance if distance > 0.0 else 0.0
    return scale * dx, scale * dy
