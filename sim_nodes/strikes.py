"""Blame for contacts: the one that moves into the other is to blame, by velocities at the point of contact.

Engines take away the speed of an impact within the step in which it is found. So velocities are those of the last
tick before the contact, which is at most 20 ms older, or the present ones of what was not looked at then, because
it was at rest. A contact has strikers by the first of these rules that fits:

1. What was put somewhere within the last tick is the striker; a robot that was put somewhere is not to blame.
2. What a gripper holds belongs to the arm: the two never strike each other, and what the held body strikes, the
   arm strikes. It may be set down: a contact below it, whose normal is within 45 degrees of vertical, is free.
3. Who approaches the other with more than 0.01 m/s along the normal of a point is a striker; that may be both.
4. If nobody does, whoever moves at a point with more than 0.01 m/s in any direction is: it grazes the other.

A robot that is pushed by another striker into a third thing is not to blame for that contact.

A contact that lasts has a striker again when a robot pushes: when the velocity that its wheels are commanded,
or that its joints have, leads into the other with more than 0.01 m/s. A robot that was struck has half a second to
react before that counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sim_nodes.entities import Entities
from sim_nodes.geometry import Array, Vector
from sim_nodes.physics import Engine, TouchPoint
from sim_nodes.robots.motion import Sample
from sim_nodes.robots.robot import Robot
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

MOVING = 0.01  # [m/s] from which something approaches another, or moves at all
REACTION = 0.5  # [s] after which a robot that was struck pushes
DOWNWARD = math.cos(math.pi / 4)  # part of a normal that is vertical, where something is set down

Pair = tuple[str, str]


@dataclass(frozen=True)
class Strike:
    """A contact that is judged: who moved into whom, and where.

    Attributes:
        strikers: Names of those who did; also robots whose grippers hold the entity that did.
        position: Of a point of contact in the map [m]; None where the engine has none.
        held: What of the two is held, and by which robot.
    """

    strikers: tuple[str, ...]
    position: Vector | None
    held: Mapping[str, str]


class Strikes(Stateful):
    """Follows how robots and bodies move, and judges contacts by it.

    Args:
        engine: Has them.
        entities: What is in the world besides robots.
        robots: The robots, by name.
        tick_steps: Physics steps of a tick.
    """

    STATE = ("_samples", "_placed", "_strikers", "_since")

    def __init__(self, engine: Engine, entities: Entities, robots: Mapping[str, Robot], tick_steps: int) -> None:
        self._engine, self._entities, self._robots = engine, entities, robots
        self._tick_steps = tick_steps
        self._samples: dict[str, Sample] = {}
        self._placed: dict[str, int] = {}  # step after which something was put somewhere
        self._strikers: dict[Pair, tuple[str, ...]] = {}  # of contacts that last
        self._since: dict[Pair, int] = {}  # ticks in which these began

    def sample(self, robots: Iterable[str], tick: int) -> None:
        """Note how robots move, and everything that can be pushed."""
        kept = {name: sample for name, sample in self._samples.items() if name in self._robots}
        self._samples = kept | {name: self._now(name, tick) for name in (*robots, *self._entities.movable())}

    def placed(self, name: str, step: int) -> None:
        """Note that something was put somewhere after a step, and that it has not moved there."""
        self._samples.pop(name, None)
        recent = {other: when for other, when in self._placed.items() if step - when <= self._tick_steps}
        self._placed = recent | {name: step}

    def commanded(self, robot: str) -> None:
        """Note that a robot got a new command: what it pushes from now on, it strikes again."""
        self._strikers = {pair: _without(robot, strikers) for pair, strikers in self._strikers.items()}

    def begins(self, pair: Pair, step: int, touching: frozenset[Pair]) -> Strike:
        """Judge a contact that began in a step."""
        held = self._held(pair)
        points = {name: self._points(name, pair) for name in pair}
        strikers, position = self._strikers_of(pair, points, step, held)
        strikers = tuple(name for name in strikers if not self._is_pushed(name, pair, touching))
        self._keep(touching)
        self._strikers[pair], self._since[pair] = strikers, step // self._tick_steps
        return Strike(strikers, position, held)

    def pushes(self, robot: str, touching: frozenset[Pair], tick: int) -> Iterator[tuple[Pair, Strike]]:
        """Judge contacts of a robot that last: those in which it begins to push, sorted."""
        self._keep(touching)
        pairs = [pair for pair in sorted(touching) if robot in pair and not self._holds(robot, pair)]
        if not pairs:
            return
        points = self._engine.touch_points(robot)
        told = self._robots[robot].told_motion(self._now(robot, tick))
        for pair in pairs:
            there = [point for point in points if point.entity == _other(pair, robot)]
            pressed = [point for point in there if self._approach(robot, point, told) > MOVING]
            if not pressed:
                self._strikers[pair] = _without(robot, self._strikers.get(pair, ()))
            elif self._may_push(robot, pair, tick):
                self._strikers[pair] = (*self._strikers.get(pair, ()), robot)
                yield pair, Strike((robot,), pressed[0].position, self._held(pair))

    def _may_push(self, robot: str, pair: Pair, tick: int) -> bool:
        """Whether a robot would be to blame for pushing, and is not yet."""
        strikers = self._strikers.get(pair, ())
        reacts = bool(strikers) and (tick - self._since.get(pair, tick)) * TICK < REACTION
        return robot not in strikers and not reacts

    def _holds(self, robot: str, pair: Pair) -> bool:
        """Whether a robot holds the other of two."""
        return self._held(pair).get(_other(pair, robot)) == robot

    # ------------------------------------------------------------ who

    def _strikers_of(
        self, pair: Pair, points: Mapping[str, Sequence[TouchPoint]], step: int, held: Mapping[str, str]
    ) -> tuple[tuple[str, ...], Vector | None]:
        where = [point.position for name in pair for point in points[name]]
        position = where[0] if where else None
        if held and (held.get(pair[0]) == pair[1] or held.get(pair[1]) == pair[0]):
            return (), position
        placed = tuple(name for name in pair if step - self._placed.get(name, -math.inf) <= self._tick_steps)
        if placed:
            return tuple(name for name in placed if name not in self._robots), position
        tick = step // self._tick_steps
        moving = {name: self._recent(name, tick) for name in pair}
        found = [name for name in pair if self._fastest(name, points, moving, approaching=True) > MOVING]
        if not found:
            found = [name for name in pair if self._fastest(name, points, moving, approaching=False) > MOVING]
        return tuple(self._answerable(found, points, held)), position

    def _fastest(
        self,
        name: str,
        points: Mapping[str, Sequence[TouchPoint]],
        moving: Mapping[str, Sample | None],
        *,
        approaching: bool,
    ) -> float:
        """The greatest speed of something at the points of a contact, towards the other or in any direction."""
        judge = self._approach if approaching else self._speed
        return max((judge(name, point, moving[name]) for point in points[name]), default=0.0)

    def _answerable(
        self, names: Sequence[str], points: Mapping[str, Sequence[TouchPoint]], held: Mapping[str, str]
    ) -> Iterator[str]:
        """Yield those who answer for strikes: robots for what they hold, unless that is set down."""
        for name in names:
            if name not in held:
                yield name
            elif not all(point.normal[2] < -DOWNWARD for point in points[name]):
                yield held[name]

    def _is_pushed(self, name: str, pair: Pair, touching: frozenset[Pair]) -> bool:
        """Whether a robot is in a contact in which only the other strikes: that one moves it."""
        return name in self._robots and any(
            name in other and self._strikers.get(other) == (_other(other, name),)
            for other in touching
            if other != pair
        )

    def _keep(self, touching: frozenset[Pair]) -> None:
        """Forget contacts that are over."""
        if not self._strikers.keys() <= touching:
            self._strikers = {pair: who for pair, who in self._strikers.items() if pair in touching}
            self._since = {pair: tick for pair, tick in self._since.items() if pair in touching}

    def _held(self, pair: Pair) -> dict[str, str]:
        """Return which of two is held, and by which robot."""
        holding = {robot.held: name for name, robot in self._robots.items() if robot.held}
        return {name: holding[name] for name in pair if name in holding}

    # ------------------------------------------------------------ velocities

    def _points(self, name: str, pair: Pair) -> list[TouchPoint]:
        """The points in which one of two touches the other; walls do not move, and have none."""
        if name not in self._robots and not self._entities.is_loose(name):
            return []
        other = _other(pair, name)
        return [point for point in self._engine.touch_points(name) if point.entity == other]

    def _recent(self, name: str, tick: int) -> Sample | None:
        """Return the motion in the last tick, or now, if it was not sampled then; None for static entities."""
        found = self._samples.get(name)
        if found is not None and tick - found.tick <= 1:
            return found
        return self._now(name, tick) if name in self._robots or self._entities.is_loose(name) else None

    def _now(self, name: str, tick: int) -> Sample:
        robot = self._robots.get(name)
        if robot is None:
            return Sample(tick, self._engine.body_state(name))
        return robot.motion(tick)

    def _approach(self, name: str, point: TouchPoint, moving: Sample | None) -> float:
        """Return the speed towards the other at a point [m/s]."""
        if moving is None:
            return 0.0
        return float(self._velocity(name, point, moving) @ point.normal)

    def _speed(self, name: str, point: TouchPoint, moving: Sample | None) -> float:
        """Return the speed at a point [m/s]."""
        if moving is None:
            return 0.0
        return math.hypot(*self._velocity(name, point, moving).tolist())

    def _velocity(self, name: str, point: TouchPoint, moving: Sample) -> Array:
        """The velocity of something at a point [m/s]."""
        base = moving.base
        arm = np.subtract(point.position, base.position)
        velocity: Array = np.add(base.linear, np.cross(base.angular, arm))
        robot = self._robots.get(name)
        if robot is None or not point.link:
            return velocity
        return velocity + robot.arm.velocity_at(point.link, point.position, moving.joints, moving.rates)


def _other(pair: Pair, name: str) -> str:
    return pair[1] if pair[0] == name else pair[0]


def _without(name: str, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(other for other in names if other != name)
