"""Agents of a world file: traits and places drawn by the seed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib.util import find_spec

import numpy as np

from seoro.bridges.wire import Avoidance, WorldResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.agents.agent import Agent, Motion, Point, Stand, Walk, Wander, cart_model, person_model
from sim_nodes.agents.schema import (
    AgentFile,
    Area,
    CartFile,
    Colour,
    CrowdFile,
    FloorPoseFile,
    PathFile,
    PersonFile,
    TraitsFile,
)
from sim_nodes.agents.walls import Walls
from sim_nodes.geometry import Pose2
from sim_nodes.noise import Noise
from sim_nodes.outcomes import feature_unsupported
from sim_nodes.views import Colour as Paint

TRIES = 1000  # random places of a person of a crowd
GAP = 0.1  # [m] between people at the start
ROBOT_GAP = 0.5  # [m] between people of a crowd and robots at the start
WALL_GAP = 0.05  # [m] between people of a crowd and walls at the start

Taken = list[tuple[float, float, float]]  # x, y and radius of circles [m]


def draw_agents(
    files: Sequence[AgentFile], world: str, seed: int, walls: Walls, robots: Iterable[tuple[Pose2, float]]
) -> dict[str, Agent]:
    """Return the agents of a world by name, in the order of its file.

    Args:
        files: Entries of the file.
        world: Name of the world, for messages.
        seed: Seed of the simulation.
        walls: Walls of the world.
        robots: Initial poses and radii [m] of robots, which crowds keep free.

    Raises:
        RequestRefused: A path leads through a wall, or the area of a crowd has no room.
    """
    taken: Taken = [(pose.x, pose.y, radius + ROBOT_GAP) for pose, radius in robots]
    agents: dict[str, Agent] = {}
    for file in files:
        for name, agent in _agents_of(file, world, seed, walls, taken):
            _check_path(world, name, agent, walls)
            taken.append((agent.pose.x, agent.pose.y, agent.radius + GAP))
            agents[name] = agent
    return agents


def _agents_of(file: AgentFile, world: str, seed: int, walls: Walls, taken: Taken) -> Iterator[tuple[str, Agent]]:
    match file:
        case CartFile():
            yield file.name, _cart(file)
        case PersonFile():
            yield file.name, _person(file, file.name, seed, file.pose)
        case CrowdFile():
            for name in file.names:
                draw = Noise(seed, f"{name}/place").at(0)
                person = _person(file, name, seed, FloorPoseFile(yaw=float(draw.uniform(-math.pi, math.pi))))
                place = _free_place(file.area, draw, person.radius, walls, taken)
                if place is None:
                    raise RequestRefused(
                        WorldResult.RESOURCE_PARSE_ERROR,
                        f"{world}: found no free place for {name!r} in the `area` of the crowd {file.name!r}; "
                        "expected a larger area, or a smaller `count`",
                    )
                yield name, replace(person, pose=Pose2(*place, person.pose.yaw))


def _cart(file: CartFile) -> Agent:
    length, width, _ = file.size
    motion = _walk(file.path, file.speed)
    pose = Pose2(file.pose.x, file.pose.y, file.pose.yaw)
    model = cart_model(file.size, file.mass, _paint(file.colour))
    radius = math.hypot(length, width) / 2.0
    return Agent(model, pose, file.speed, radius, Avoidance.NONE, motion, False, file.tags)


def _person(file: TraitsFile, name: str, seed: int, pose: FloorPoseFile) -> Agent:
    avoid = Avoidance(file.avoid)
    check_avoidance(avoid)
    draw = Noise(seed, f"{name}/traits").at(0)
    speed, radius = (_value(each, draw) for each in (file.speed, file.radius))
    motion: Motion = _walk(file.walk, speed) if file.wander is None else Wander(file.wander, speed)
    model = person_model(radius, file.height, _paint(file.colour))
    place = Pose2(pose.x, pose.y, pose.yaw)
    return Agent(model, place, speed, radius, avoid, motion, True, file.tags)


def _value(given: float | tuple[float, float], draw: np.random.Generator) -> float:
    return float(draw.uniform(*given)) if isinstance(given, tuple) else given


def check_avoidance(avoid: Avoidance) -> None:
    """Refuse a way to avoid others whose library is not installed."""
    if avoid is Avoidance.ORCA and find_spec("pyrvo") is None:
        raise feature_unsupported(
            "the package pyrvo is missing, which people with `orca` need; install it with "
            "`pip install 'seoro[people]'`, or choose `social_force`"
        )


def _walk(path: PathFile | None, speed: float) -> Motion:
    return Stand() if path is None else Walk(path.points, speed, path.repeat)


def _paint(colour: Colour | None) -> Paint | None:
    return None if colour is None else (*colour, 1.0)


def _free_place(area: Area, draw: np.random.Generator, radius: float, walls: Walls, taken: Taken) -> Point | None:
    """Return a random place of an area that is free of walls and others; None if none was found."""
    left, bottom, right, top = area
    points = draw.uniform((left, bottom), (right, top), (TRIES, 2))
    free = walls.distances(points) > radius + WALL_GAP
    circles = np.array(taken).reshape(-1, 3)
    apart = np.hypot(points[:, 0, None] - circles[:, 0], points[:, 1, None] - circles[:, 1])
    free &= (apart > circles[:, 2] + radius).all(axis=1)
    free &= np.array([walls.is_inside((x, y)) for x, y in points.tolist()])
    return None if not free.any() else tuple(points[free.argmax()].tolist())


def _check_path(world: str, name: str, agent: Agent, walls: Walls) -> None:
    """Refuse places and paths outside of the world or through walls."""
    problem = walls.describe_block(path_of(agent.motion, (agent.pose.x, agent.pose.y)), agent.radius)
    if problem:
        raise RequestRefused(WorldResult.RESOURCE_PARSE_ERROR, f"{world}: {name!r}: {problem}")


def path_of(motion: Motion, start: Point) -> tuple[Point, ...]:
    """Return the line from a start along a motion [m]; only the start for motions without a path."""
    if not isinstance(motion, Walk):
        return (start,)
    return (start, *motion.points, *(motion.points[:1] if motion.repeat else ()))
