"""Queue of goals that a robot executes one at a time."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio

from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle


class GoalQueue:
    """Queue of goals: a new goal stops the earlier ones, and waits for their end."""

    def __init__(self) -> None:
        self._goals: list[GoalHandle] = []
        self._turn = anyio.Lock()

    @property
    def has_goals(self) -> bool:
        """Whether the queue has goals."""
        return bool(self._goals)

    def reserve(self, goal: GoalHandle) -> None:
        """Add an accepted goal before it takes its turn."""
        self._goals.append(goal)

    @asynccontextmanager
    async def turn(self, goal: GoalHandle, others: GoalEnd) -> AsyncIterator[None]:
        """Take the turn for the duration of the block.

        Args:
            goal: Goal to execute.
            others: End of the earlier goals.
        """
        if goal not in self._goals:
            self.reserve(goal)
        for other in self._goals[: self._goals.index(goal)]:
            other.stop(others)
        try:
            async with self._turn:
                yield
        finally:
            self._goals.remove(goal)
