"""A scenario by which a robot is left in order after a run: a run of its own, in what the first has open."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import anyio

from seoro.background import background
from seoro.bindings.implementations import BoundFunctions
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import BackendError
from seoro.lang.plan import Plan
from seoro.reasons import reason_text
from seoro.runtime.clock import RealClock, SimulatorClock
from seoro.runtime.contracts import Clock
from seoro.runtime.homes import Placement
from seoro.runtime.run import Execution, Settings
from seoro.runtime.timetable import TIME_DIGITS
from seoro.runtime.verdict import RunStatus


@dataclass(frozen=True)
class Reset:
    """A scenario, loaded.

    Args:
        plan: What it does.
        functions: Which carry out its actions and modifiers.
        actors: Names of its actors.
    """

    plan: Plan
    functions: BoundFunctions
    actors: tuple[str, ...]


Resets = Callable[[Path, str], Reset]
"""Loads the scenario of a file, which is named at a place in a lab file."""


class Resetting:
    """A run of such a scenario, which may begin.

    Args:
        reset: The scenario.
        node: Where the robot lives.
        placement: Of the robot.
        seed: Of everything that is drawn.
        within: How long it may take [s].

    Raises:
        InvalidUse: It cannot be run with that robot.
    """

    def __init__(
        self, reset: Reset, node: SimulatorNode | RobotNode, placement: Placement, seed: int, within: float
    ) -> None:
        self._limit: float | None = None  # of the machine's clock
        clock: Clock
        if isinstance(node, SimulatorNode):
            clock = SimulatorClock(_TimeFromNow(node, within), math.inf)
        else:
            clock, self._limit = RealClock(), within
        (actor,) = reset.actors
        self._execution = Execution(
            reset.plan,
            Settings(
                seed=seed,
                clock=clock,
                backends=(node,),
                placements={actor: placement},
                actions=reset.functions.actions,
                modifiers=reset.functions.modifiers,
            ),
        )

    async def carry_out(self) -> None:
        """Run it to its end.

        Raises:
            BackendError: It has not passed; says why, and where in its text.
        """
        async with background() as group:
            if self._limit is not None:
                group.start_soon(self._end_after, self._limit)
            verdict = await self._execution.run()
        if verdict.status is not RunStatus.PASSED:
            raise BackendError(reason_text(verdict))

    async def _end_after(self, limit: float) -> None:
        await anyio.sleep(limit)
        self._execution.fail_backend(BackendError(_too_long(limit)))


class _TimeFromNow:
    """The time of a simulator from when it is first asked for, and so much of it at most [s]."""

    def __init__(self, node: SimulatorNode, limit: float) -> None:
        self._node = node
        self._limit = limit
        self._since: float | None = None

    async def advance(self, until: float) -> float:
        """See `TimeServer`."""
        if self._since is None:
            self._since = self._node.time
        if self._node.time - self._since >= self._limit:
            raise BackendError(_too_long(self._limit))
        reached = await self._node.advance(self._since + min(until, self._limit))
        return round(reached - self._since, TIME_DIGITS)


def _too_long(limit: float) -> str:
    return f"it takes longer than {limit:g} s"
