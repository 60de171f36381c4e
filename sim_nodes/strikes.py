"""Contacts: when they begin, and the entities that caused them (strikers), by velocities at the contact points.

Engines resolve the speed of an impact within the step in which it is detected. So velocities are those of the last
tick before the contact, at most 20 ms earlier; for entities at rest, which are not sampled, the present ones. The
first rule that applies gives the strikers:

1. An entity that was placed within the last tick is the striker, except a robot.
2. A held entity belongs to the arm: the two never strike each other, and what the held body strikes, the arm
strikes. Setting it down is free: a contact below it, with a normal within 45 degrees of vertical.
3. An entity that approaches the other one with more than 0.01 m/s along the normal is a striker; possibly both.
4. Otherwise, an entity that moves at the contact with more than 0.01 m/s in any direction is: it grazes the other.

A robot that another striker pushes into a third entity is not a striker of that contact.

A lasting contact gets a new striker when a robot pushes. It pushes if the commanded velocity of its wheels, or the
velocity of its joints, leads into the other entity with more than 0.01 m/s. A robot that was struck has half a
second to react.

The surface of a lift counts as floor: contacts with entities on it are not reported.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.entities import Entities
from sim_nodes.geometry import Array, Vector
from sim_nodes.physics import ContactPoint, Engine
from sim_nodes.robots.robot import Robot, Sample
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

MOVING = 0.01  # [m/s] minimum speed of an approach or motion
REACTION = 0.5  # [s] after which a struck robot may count as pushing
DOWNWARD = math.cos(math.pi / 4)  # vertical component of the normal from which an entity is set down
RELEASE_TIME = 0.5  # [s] without touch after which a contact has ended

Pair = tuple[str, str]


class Contacts(Stateful):
    """Detects when contacts begin. A rattling contact begins once: it ends only after a time without touch.

    Args:
        steps_per_second: Physics steps per simulated second.

    Attributes:
        touching: Pairs in contact in the last step.
    """

    STATE = ("touching", "_released")

    def __init__(self, steps_per_second: int) -> None:
        self._release_steps = round(RELEASE_TIME * steps_per_second)
        self.touching: frozenset[Pair] = frozenset()
        self._released: dict[Pair, int] = {}  # pairs that separated, and the last step in which they touched

    def touches(self, name: str) -> bool:
        """Whether an entity was in contact in the last step."""
        return bool(self.touching) and any(name in pair for pair in self.touching)

    def update(self, touching: frozenset[Pair], step: int) -> Iterator[Pair]:
        """Update the pairs in contact after a step; yields the pairs whose contact begins, sorted."""
        if touching == self.touching:
            return
        for pair in self.touching - touching:
            self._released[pair] = step - 1
        oldest = step - 1 - self._release_steps
        self._released = {pair: last for pair, last in self._released.items() if last >= oldest}
        begun = sorted(touching - self.touching)
        self.touching = touching
        for pair in begun:
            if self._released.pop(pair, None) is None:
                yield pair


@dataclass(frozen=True)
class JudgedContact:
    """A contact with its strikers and position.

    Attributes:
        strikers: Names of strikers; also robots that hold one.
        position: A contact point in `map` [m]; None if the engine has none.
        held: Robot that holds it, for each of the two that is held.
    """

    strikers: tuple[str, ...]
    position: Vector | None
    held: Mapping[str, str]


class Strikes(Stateful):
    """Tracks the motion of robots and bodies, and attributes contacts.

    Args:
        engine: Engine with the present states.
        entities: Entities of the world besides robots.
        robots: Robots by name.
        tick_steps: Physics steps per tick.
    """

    STATE = ("_samples", "_placed", "_strikers", "_since")

    def __init__(self, engine: Engine, entities: Entities, robots: Mapping[str, Robot], tick_steps: int) -> None:
        self._engine, self._entities, self._robots = engine, entities, robots
        self._tick_steps = tick_steps
        self._with_arms = frozenset(name for name, robot in robots.items() if robot.declaration.arm is not None)
        self._samples: dict[str, Sample] = {}
        self._placed: dict[str, int] = {}  # step after which an entity was placed
        self._strikers: dict[Pair, tuple[str, ...]] = {}  # of lasting contacts
        self._since: dict[Pair, int] = {}  # ticks in which these began

    def sample_motion(self, robots: Iterable[str], tick: int) -> None:
        """Sample the motion of robots and movable bodies."""
        bodies, samples = self._entities.movable(), self._samples
        for name in [name for name in samples if name not in self._robots and name not in bodies]:
            del samples[name]
        state = self._engine.body_state
        for name in (*robots, *bodies):
            samples[name] = self._now(name, tick) if name in self._with_arms else Sample(tick, state(name))

    def on_placed(self, name: str, step: int) -> None:
        """Record that an entity was placed, at rest, after a step."""
        self._samples.pop(name, None)
        recent = {other: when for other, when in self._placed.items() if step - when <= self._tick_steps}
        self._placed = recent | {name: step}

    def on_command(self, robot: str) -> None:
        """Record a new command of a robot: pushing from now on makes it a striker again."""
        self._strikers = {pair: _without(robot, strikers) for pair, strikers in self._strikers.items()}

    def is_on_lift(self, pair: Pair) -> bool:
        """Whether one of a pair stands on the other, which is a lift."""
        for name in pair:
            if _other(pair, name) in self._entities.lifts:
                points = self._points(name, pair)
                return bool(points) and all(point.normal[2] < -DOWNWARD for point in points)
        return False

    def judge_contact(self, pair: Pair, step: int, touching: frozenset[Pair]) -> JudgedContact:
        """Attribute a contact that began in a step."""
        held = self._held(pair)
        points = {name: self._points(name, pair) for name in pair}
        position = next((point.position for name in pair for point in points[name]), None)
        found = self._strikers_of(pair, points, step, held)
        strikers = tuple(name for name in found if not self._is_pushed(name, pair, touching))
        self._drop_ended(touching)
        self._strikers[pair], self._since[pair] = strikers, step // self._tick_steps
        return JudgedContact(strikers, position, held)

    def judge_push(self, robot: str, touching: frozenset[Pair], tick: int) -> Iterator[tuple[Pair, JudgedContact]]:
        """Attribute lasting contacts of a robot in which it begins to push, sorted."""
        self._drop_ended(touching)
        pairs = [pair for pair in sorted(touching) if robot in pair and not self._holds(robot, pair)]
        if not pairs:
            return
        points = self._engine.contact_points(robot)
        commanded = self._robots[robot].commanded_motion(self._now(robot, tick))
        for pair in pairs:
            there = [point for point in points if point.entity == _other(pair, robot)]
            pressed = [point for point in there if self._approach(robot, point, commanded) > MOVING]
            if not pressed:
                self._strikers[pair] = _without(robot, self._strikers.get(pair, ()))
            elif self._may_push(robot, pair, tick):
                self._strikers[pair] = (*self._strikers.get(pair, ()), robot)
                yield pair, JudgedContact((robot,), pressed[0].position, self._held(pair))

    def _may_push(self, robot: str, pair: Pair, tick: int) -> bool:
        """Whether pushing would make a robot a striker."""
        strikers = self._strikers.get(pair, ())
        reacts = bool(strikers) and (tick - self._since.get(pair, tick)) * TICK < REACTION
        return robot not in strikers and not reacts

    def _holds(self, robot: str, pair: Pair) -> bool:
        """Whether a robot holds the other one of a pair."""
        return self._held(pair).get(_other(pair, robot)) == robot

    # ------------------------------------------------------------ strikers

    def _strikers_of(
        self, pair: Pair, points: Mapping[str, Sequence[ContactPoint]], step: int, held: Mapping[str, str]
    ) -> Iterable[str]:
        if held.get(pair[0]) == pair[1] or held.get(pair[1]) == pair[0]:
            return ()
        placed = [name for name in pair if step - self._placed.get(name, -math.inf) <= self._tick_steps]
        if placed:
            return [name for name in placed if name not in self._robots]
        moving = {name: self._recent(name, step // self._tick_steps) for name in pair if points[name]}
        for speed in (self._approach, self._speed):
            found = [
                name
                for name, motion in moving.items()
                if any(speed(name, it, motion) > MOVING for it in points[name])
            ]
            if found:
                return self._responsible(found, points, held)
        return ()

    def _responsible(
        self, names: Sequence[str], points: Mapping[str, Sequence[ContactPoint]], held: Mapping[str, str]
    ) -> Iterator[str]:
        """Yield the strikers: robots instead of the entities that they hold, unless those are set down."""
        for name in names:
            if name not in held:
                yield name
            elif not all(point.normal[2] < -DOWNWARD for point in points[name]):
                yield held[name]

    def _is_pushed(self, name: str, pair: Pair, touching: frozenset[Pair]) -> bool:
        """Whether a robot is moved by a contact in which only the other one strikes."""
        return name in self._robots and any(
            name in other and self._strikers.get(other) == (_other(other, name),)
            for other in touching
            if other != pair
        )

    def _drop_ended(self, touching: frozenset[Pair]) -> None:
        """Drop contacts that have ended."""
        if not self._strikers.keys() <= touching:
            self._strikers = {pair: strikers for pair, strikers in self._strikers.items() if pair in touching}
            self._since = {pair: tick for pair, tick in self._since.items() if pair in touching}

    def _held(self, pair: Pair) -> dict[str, str]:
        """Return which of a pair is held, and by which robot."""
        holding = {robot.held: name for name, robot in self._robots.items() if robot.held}
        return {name: holding[name] for name in pair if name in holding}

    # ------------------------------------------------------------ velocities

    def _points(self, name: str, pair: Pair) -> list[ContactPoint]:
        """Return the contact points of one of a pair; static entities have none."""
        if name not in self._robots and not self._entities.is_movable(name):
            return []
        other = _other(pair, name)
        return [point for point in self._engine.contact_points(name) if point.entity == other]

    def _recent(self, name: str, tick: int) -> Sample:
        """Return the motion of a robot or movable entity in the last tick, or now, if it was not sampled then."""
        found = self._samples.get(name)
        return found if found is not None and tick - found.tick <= 1 else self._now(name, tick)

    def _now(self, name: str, tick: int) -> Sample:
        robot = self._robots.get(name)
        if robot is None:
            return Sample(tick, self._engine.body_state(name))
        return robot.motion(tick)

    def _approach(self, name: str, point: ContactPoint, moving: Sample) -> float:
        """Return the speed towards the other one at a point [m/s]."""
        return float(self._velocity(name, point, moving) @ point.normal)

    def _speed(self, name: str, point: ContactPoint, moving: Sample) -> float:
        """Return the speed at a point [m/s]."""
        return math.hypot(*self._velocity(name, point, moving).tolist())

    def _velocity(self, name: str, point: ContactPoint, moving: Sample) -> Array:
        """Return the velocity of an entity at a point in `map` [m/s]."""
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
