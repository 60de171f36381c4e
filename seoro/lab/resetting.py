"""Reset scenarios of robots after a run, which use the connections of the run."""

from __future__ import annotations

import math
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio

from seoro.bindings.bound_functions import BoundFunctions
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.concurrency.background import background
from seoro.embed.backends import actor_names
from seoro.errors import BackendError
from seoro.lang.plan import Plan
from seoro.runtime.execution.assignment import Placement
from seoro.runtime.execution.settings import Settings
from seoro.runtime.explain.reasons import reason_text
from seoro.runtime.kernel.clock import TIME_DIGITS, Clock, RealClock, SimulatorClock
from seoro.runtime.run import Execution
from seoro.runtime.verdict import RunStatus


@dataclass(frozen=True)
class Reset:
    """A loaded reset scenario.

    Args:
        plan: Plan of the scenario.
        functions: Implementations of its actions and modifiers.
    """

    plan: Plan
    functions: BoundFunctions


Resets = Callable[[Path, str], Reset]
"""Loads a reset scenario from a path, which has a position in a lab file."""


class ResetRun:
    """Run of a reset scenario.

    Args:
        reset: The scenario.
        node: Node of the robot.
        placement: Placement of the actor in the robot.
        seed: Random seed.
        within: Time limit [s].

    Raises:
        UsageError: The scenario cannot run with that robot.
    """

    def __init__(
        self, reset: Reset, node: SimulatorNode | RobotNode, placement: Placement, seed: int, within: float
    ) -> None:
        self._limit: float | None = None  # [s] of the machine's clock
        clock: Clock
        if isinstance(node, SimulatorNode):
            clock = SimulatorClock(_RelativeTime(node, within), math.inf)
        else:
            clock, self._limit = RealClock(), within
        (actor,) = actor_names(reset.plan)
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

    async def run(self) -> None:
        """Run the scenario.

        Raises:
            BackendError: The scenario has not passed; the message has the reason and its position.
        """
        async with background() as group:
            if self._limit is not None:
                group.start_soon(self._end_after, self._limit)
            async with _shielded(self._execution.stop):
                verdict = await self._execution.run()
        if verdict.status is not RunStatus.PASSED:
            raise BackendError(reason_text(verdict))

    async def _end_after(self, limit: float) -> None:
        await anyio.sleep(limit)
        self._execution.fail_backend(BackendError(_too_long(limit)))


@asynccontextmanager
async def _shielded(stop: Callable[[str], None]) -> AsyncGenerator[None]:
    """Call `stop` when a cancel scope around the block is cancelled, without interrupting the block.

    Leaving the block raises if such a scope or this task was cancelled.

    Args:
        stop: Called immediately, with the reason.
    """

    async def call_when_cancelled() -> None:
        try:
            await anyio.sleep_forever()
        finally:
            stop("its task was cancelled")  # no effect at the end of the block

    async with anyio.create_task_group() as watch:
        watch.start_soon(call_when_cancelled)
        with anyio.CancelScope(shield=True):
            yield
        watch.cancel_scope.cancel()


class _RelativeTime:
    """Time of a simulator since the first grant, up to a limit [s]."""

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
