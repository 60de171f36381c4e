"""The doors and lifts of a simulation: goals, locks, automatic doors, obstacles, and velocities in each tick."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence, Set
from dataclasses import replace
from typing import TypeVar

import numpy as np

from seoro.bridges.wire import Outcome
from sim_nodes.buildings.obstacles import BodyMotion
from sim_nodes.buildings.parts import BuildingPart, Door, Lift, Place
from sim_nodes.buildings.travel import PATIENCE, Travel
from sim_nodes.geometry import Array, wrap
from sim_nodes.outcomes import GoalResult, incorrect_state, unknown
from sim_nodes.physics import Engine
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

Pair = tuple[str, str]
P = TypeVar("P", Door, Lift)


class Buildings(Stateful):
    """The doors and lifts of a simulation.

    Args:
        parts: Doors and lifts, in the order of their bodies in the engine.
        engine: Engine with their bodies.
    """

    STATE = ("_travels", "_locked", "_open_until")

    def __init__(self, parts: Sequence[BuildingPart], engine: Engine) -> None:
        self._engine = engine
        self._parts = {part.name: part for part in parts}
        self._travels = {part.name: Travel(part.start, part.start, reached=part.start) for part in parts}
        self._locked = {part.name for part in parts if isinstance(part, Door) and part.locked}
        self._open_until: dict[str, int] = {}  # ticks until which automatic doors stay open

    def __bool__(self) -> bool:
        return bool(self._parts)

    # ------------------------------------------------------------ requests

    def door(self, name: str) -> Door:
        """Return a door by name.

        Raises:
            RequestRefused: It is unknown.
        """
        return self._part(name, Door)

    def lift(self, name: str) -> Lift:
        """Return a lift by name.

        Raises:
            RequestRefused: It is unknown.
        """
        return self._part(name, Lift)

    def _part(self, name: str, kind: type[P]) -> P:
        part = self._parts.get(name)
        if not isinstance(part, kind):
            known = [other.name for other in self._parts.values() if isinstance(other, kind)]
            raise unknown(f"{kind.kind} {name!r}", f"{kind.kind}s", known)
        return part

    def position(self, name: str) -> float | None:
        """Return the opening of a door, or the height of a lift [m]; None if it is unknown."""
        return self._travels[name].position if name in self._travels else None

    def start(self, name: str, target: float, goal: str, tick: int) -> None:
        """Start the travel of a door or a lift to a position, whose end is reported.

        Raises:
            RequestRefused: It is locked, or has another goal.
        """
        travel = self._travels[name]
        if travel.goal is not None:
            raise incorrect_state(f"{name} is busy with goal {travel.goal!r}; cancel it or wait for its end")
        if name in self._locked and target != travel.position:
            raise incorrect_state(f"{name} is locked; unlock it first")
        self._travels[name] = travel.towards(target, tick, goal)

    def lock(self, name: str, *, locked: bool) -> None:
        """Lock or unlock a door.

        Raises:
            RequestRefused: It is not closed, and cannot be locked.
        """
        travel = self._travels[name]
        if locked and not (travel.position == travel.target == 0.0):
            raise incorrect_state(
                f"{name} is {self._parts[name].describe(travel.position)}; close it before you lock it"
            )
        (self._locked.add if locked else self._locked.discard)(name)

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of active goals that a client waits for."""
        return tuple(travel.goal for travel in self._travels.values() if travel.goal is not None)

    def cancel(self, goal: str) -> Iterator[GoalResult]:
        """Cancel a goal by id, and stop its door or lift; yields its result."""
        for name, travel in self._travels.items():
            if travel.goal == goal:
                self._travels[name] = travel.stopped()
                yield GoalResult(goal, Outcome.CANCELED)

    def cancel_all(self) -> Iterator[GoalResult]:
        """Cancel all goals; yields their results."""
        for goal in self.goals:
            yield from self.cancel(goal)

    def detach_goals(self, goals: Container[str]) -> None:
        """Continue some goals without their client: their results are not reported."""
        for name, travel in self._travels.items():
            if travel.goal is not None and travel.goal in goals:
                self._travels[name] = replace(travel, goal=None)

    # ------------------------------------------------------------ ticks

    def tick(self, tick: int, touching: Set[Pair], visitors: Callable[[], Array]) -> Iterator[GoalResult]:
        """Advance all travels to the next tick; yields the results of goals that ended.

        Args:
            tick: The present tick.
            touching: Pairs of entities in contact.
            visitors: Returns the positions that automatic doors open for, shape (n, 2) [m].
        """
        self._move_automatic_doors(tick, visitors)
        met = {name for pair in touching for name in pair}
        for name, part in self._parts.items():
            travel = self._travels[name]
            moved = travel.advanced(part.limits, tick)
            if moved.position != travel.position:
                obstacle = self._obstacle(part, moved.position, met)
                moved = moved if not obstacle else self._stop_before(part, travel, obstacle, tick)
            self._travels[name] = moved
            yield from self._end_of(part, travel, tick)

    def motion(self, poses: Array) -> tuple[Array, Array]:
        """Return velocities and heights of the bodies, the arguments of `DrivesBodies.drive_bodies`.

        Args:
            poses: Their present poses: x, y [m] and yaw [rad], shape (n, 3).
        """
        places = np.array([place for name, part in self._parts.items() for place in self._places(part, name)])
        places = places.reshape(-1, 4)
        velocities = np.column_stack([places[:, :2] - poses[:, :2], wrap(places[:, 3] - poses[:, 2])]) / TICK
        return velocities, places[:, 2]

    def _places(self, part: BuildingPart, name: str) -> tuple[Place, ...]:
        return part.places(self._travels[name].position)

    def _move_automatic_doors(self, tick: int, visitors: Callable[[], Array]) -> None:
        """Open automatic doors for visitors, and close them afterwards, unless they have a goal."""
        doors = [part for part in self._parts.values() if isinstance(part, Door) and part.automatic is not None]
        if not doors:
            return
        places = visitors()
        for door in doors:
            assert door.automatic is not None
            travel = self._travels[door.name]
            if travel.goal is not None or door.name in self._locked:
                continue
            away = np.hypot(places[:, 0] - door.middle[0], places[:, 1] - door.middle[1])
            opens = travel.target == 1.0 and not travel.has_arrived
            if opens or (away <= door.automatic.range).any():
                self._open_until[door.name] = tick + round(door.automatic.hold / TICK)
            target = 1.0 if tick <= self._open_until.get(door.name, -1) else 0.0
            if target != travel.target:
                self._travels[door.name] = travel.towards(target, tick)

    def _obstacle(self, part: BuildingPart, position: float, met: Set[str]) -> str:
        """Return an entity that a body would press against on its way to a position; empty for none."""
        own = {name for name, _ in part.bodies}
        for (name, model), place in zip(part.bodies, part.places(position), strict=True):
            if name in met:
                motion = BodyMotion.between(self._engine.body_state(name), place)
                for point in self._engine.contact_points(name):
                    if point.entity not in own and motion.presses(point, model):
                        return point.entity
        return ""

    def _stop_before(self, part: BuildingPart, travel: Travel, obstacle: str, tick: int) -> Travel:
        """Return the travel of a part that stands before an obstacle; automatic doors open again."""
        here = part.position([self._engine.body_state(name) for name, _ in part.bodies])
        stopped = travel.blocked(obstacle, here, tick)
        if isinstance(part, Door) and part.automatic is not None and travel.goal is None and travel.target == 0.0:
            self._open_until[part.name] = tick + round(part.automatic.hold / TICK)
            return stopped.towards(1.0, tick)
        return stopped

    def _end_of(self, part: BuildingPart, travel: Travel, tick: int) -> Iterable[GoalResult]:
        """End a goal that is reached, or without progress; yields its result."""
        if travel.goal is None:
            return
        if travel.has_arrived:
            self._travels[part.name] = self._travels[part.name].stopped()
            yield GoalResult(travel.goal, Outcome.SUCCEEDED)
        elif tick - travel.since > PATIENCE:
            self._travels[part.name] = self._travels[part.name].stopped()
            yield GoalResult(
                travel.goal,
                Outcome.ABORTED,
                f"the {part.kind} {part.name} is blocked by {travel.obstacle or 'something'}, "
                f"{part.describe(travel.position)}: no progress in {PATIENCE * TICK:g} s",
            )
