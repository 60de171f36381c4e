"""Goals of which a robot pursues one at a time."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio

from seoro.bridges.ros2.action_server import GoalEnd, ServedGoal


class Turns:
    """Lets one goal at a time be carried out: a new one ends those before it, and waits until they have."""

    def __init__(self) -> None:
        self._goals: list[ServedGoal] = []
        self._turn = anyio.Lock()

    @property
    def are_taken(self) -> bool:
        """Whether there is any goal."""
        return bool(self._goals)

    def reserve(self, goal: ServedGoal) -> None:
        """Count a goal already that has been accepted and will take its turn."""
        self._goals.append(goal)

    @asynccontextmanager
    async def take(self, goal: ServedGoal, others: GoalEnd) -> AsyncIterator[None]:
        """Have the turn for as long as the block lasts.

        Args:
            goal: Whose turn it is.
            others: How those before it end.
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
