"""Waiting until the robots that a run needs are free, and until the nodes that serve them answer."""

from __future__ import annotations

import math
import random
import time
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import replace
from typing import TypeVar

import anyio

from seoro.bridges.robot.connecting import Claim, RobotsTaken
from seoro.embed.options import Leasing
from seoro.errors import BackendUnreachable

RETRY = (0.15, 0.35)  # [s] between two attempts, drawn so that two who want the same do not meet again and again
LONGEST_RETRY = 4.0  # [s] between two attempts to reach a node that does not answer

T = TypeVar("T")


@asynccontextmanager
async def when_free(
    leasing: Leasing, opening: Callable[[Claim], AbstractAsyncContextManager[T]]
) -> AsyncIterator[T]:
    """Hold what a run needs for as long as the block lasts; a run that waits tries again until it gets all of it.

    Args:
        leasing: How the run claims robots, and for how long it waits.
        opening: Opens all of it. Raises `BackendUnreachable` if a later attempt may succeed.

    Raises:
        RobotsTaken: Others still hold something of it.
        BackendUnreachable: A node still does not answer.
    """
    claim = Claim(lease=leasing.lease, priority=leasing.priority)
    patience = _Patience(leasing)
    async with AsyncExitStack() as stack:
        while True:
            waits = patience.is_left  # the last attempt gives up the place in line
            try:
                opened = await stack.enter_async_context(opening(replace(claim, waits=waits)))
                break
            except BackendUnreachable as obstacle:
                if not waits:
                    raise
                patience.report(obstacle)
            await anyio.sleep(patience.pause())
        if patience.reported and leasing.turn is not None:
            await leasing.turn()
        yield opened


class _Patience:
    """Time that a run waits: what it reported last, and how long it pauses between attempts.

    Args:
        leasing: How the run claims robots, and for how long it waits.
    """

    def __init__(self, leasing: Leasing) -> None:
        self._leasing = leasing
        self._began = time.monotonic()
        self._unreached = 0  # attempts in a row in which a node did not answer
        self.reported = ""

    @property
    def _left(self) -> float:
        """Time until the run gives up [s]; negative if it does not wait."""
        wait = self._leasing.wait
        return -math.inf if wait is None else self._began + wait - time.monotonic()

    @property
    def is_left(self) -> bool:
        """Whether the run tries again if this attempt fails."""
        return self._left > 0.0

    def report(self, obstacle: BackendUnreachable) -> None:
        """Report what the run waits for, once for each reason."""
        self._unreached = 0 if isinstance(obstacle, RobotsTaken) else self._unreached + 1
        if self.reported != (reason := str(obstacle)):
            self.reported = reason
            if self._leasing.say is not None:
                self._leasing.say(reason)

    def pause(self) -> float:
        """Draw the time until the next attempt [s]; it doubles while a node does not answer, up to a bound."""
        drawn = random.uniform(*RETRY)  # noqa: S311 - nobody gains from guessing it
        longer = min(drawn * 2.0 ** min(self._unreached, 10), LONGEST_RETRY)
        return min(longer, max(self._left, drawn))
