"""Verbs about people and carts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.wire.refusal import check_finite, check_positive
from sim_nodes.agents.agent import Agent, Follow, Walk, Wander, person_model
from sim_nodes.agents.drawing import check_avoidance
from sim_nodes.agents.schema import HEIGHTS, MAX_AGENTS, MAX_POINTS, RADII, SPEEDS
from sim_nodes.messages import check_pose, planar
from sim_nodes.outcomes import operation_failed, unknown
from sim_nodes.simulation import Simulation
from sim_nodes.simulator import Simulator


def spawn_person(simulator: Simulator, request: wire.SpawnPerson) -> wire.EntityName:
    check_pose(request.pose, wire.SpawnResult.INVALID_POSE)
    _check_range("speed", request.speed, SPEEDS, "m/s")
    _check_range("radius", request.radius, RADII, "m")
    _check_range("height", request.height, HEIGHTS, "m")
    entities = simulator.simulation.entities
    if len(entities.agents) >= MAX_AGENTS:
        raise operation_failed(f"too many people and carts: {MAX_AGENTS} at most; delete some")
    check_avoidance(request.avoid)
    model = person_model(request.radius, request.height)
    agent = Agent(model, planar(request.pose), request.speed, request.radius, request.avoid)
    entities.spawn_agent(request.name, agent, simulator.simulation.time)
    return wire.EntityName(name=request.name)


def walk_along(simulator: Simulator, request: wire.WalkAlong) -> None:
    simulation = simulator.simulation
    points = [(point.x, point.y) for point in request.points]
    check_finite("points", *(value for point in points for value in point))
    if request.place:
        points.append(_named(simulation, request.place))
    if not 1 <= len(points) <= MAX_POINTS:
        raise operation_failed(f"found {len(points)} points of a path; expected 1 to {MAX_POINTS}")
    speed = _speed(simulation, request.person, request.speed)
    simulation.start_motion(request.person, Walk(tuple(points), speed, request.repeat), request.id)


def wander(simulator: Simulator, request: wire.Wander) -> None:
    simulation, low, high = simulator.simulation, request.lower, request.upper
    check_finite("area", low.x, low.y, high.x, high.y)
    if not (low.x < high.x and low.y < high.y):
        raise operation_failed("invalid area; expected the lower corner first")
    speed = _speed(simulation, request.person, request.speed)
    simulation.start_motion(request.person, Wander((low.x, low.y, high.x, high.y), speed), request.id)


def walk_after(simulator: Simulator, request: wire.WalkAfter) -> None:
    simulation = simulator.simulation
    check_positive("distance", request.distance, "m")
    speed = _speed(simulation, request.person, request.speed)
    followed = [*simulation.robots, *simulation.entities.bodies]
    if request.entity == request.person or request.entity not in followed:
        raise unknown(f"entity {request.entity!r} to follow", "entities", followed)
    simulation.start_motion(request.person, Follow(request.entity, request.distance, speed), request.id)


def stand_still(simulator: Simulator, request: wire.PersonName) -> None:
    simulator.simulation.stop_person(request.person)


def _named(simulation: Simulation, name: str) -> tuple[float, float]:
    """Return the position of a named pose of the world."""
    places = {pose.name: pose.place.position for pose in simulation.world.poses}
    if name not in places:
        raise unknown(f"named pose {name!r}", "named poses", places)
    x, y, _ = places[name]
    return x, y


def _speed(simulation: Simulation, person: str, speed: float) -> float:
    """Return the speed of a motion [m/s]; that of the person instead of 0."""
    usual = simulation.agents.agent(person).speed
    if speed == 0.0:
        return usual
    _check_range("speed", speed, SPEEDS, "m/s")
    return speed


def _check_range(what: str, value: float, limits: Sequence[float], unit: str) -> None:
    low, high = limits
    if not (math.isfinite(value) and low <= value <= high):
        raise operation_failed(f"invalid {what} of {value:g} {unit}; expected {low:g} to {high:g} {unit}")
