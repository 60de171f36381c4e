"""Wait for busy robots and unreachable nodes before a run."""

from __future__ import annotations

import math
import random
import time
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import replace
from typing import TypeVar

import anyio

from seoro.bridges.robot.connecting import Claim, RobotsBusy
from seoro.embed.options import Leasing
from seoro.errors import BackendUnreachable

RETRY = (0.15, 0.35)  # [s] between attempts, random so that competing runs do not keep colliding
MAX_RETRY = 4.0  # [s] between attempts to reach a node

T = TypeVar("T")


@asynccontextmanager
async def retry_until_free(
    leasing: Leasing, opening: Callable[[Claim], AbstractAsyncContextManager[T]]
) -> AsyncIterator[T]:
    """Acquire all nodes of a run while the block lasts; a waiting run retries until all are available.

    Args:
        leasing: Claim of the robots, and time limit of the wait.
        opening: Acquires all nodes. Raises `BackendUnreachable` if a later attempt may succeed.

    Raises:
        RobotsBusy: Another client still holds a robot.
        BackendUnreachable: A node still does not answer.
    """
    claim = Claim(lease=leasing.lease, priority=leasing.priority)
    patience = _RetryTimer(leasing)
    async with AsyncExitStack() as stack:
        while True:
            waits = patience.is_left  # the last attempt leaves the wait queue
            try:
                opened = await stack.enter_async_context(opening(replace(claim, waits=waits)))
                break
            except BackendUnreachable as obstacle:
                if not waits:
                    raise
                patience.report(obstacle)
            await anyio.sleep(patience.pause())
        if patience.reported and leasing.on_acquired is not None:
            await leasing.on_acquired()
        yield opened


class _RetryTimer:
    """Timer of the attempts of a waiting run, with its last report.

    Args:
        leasing: Claim of the robots, and time limit of the wait.
    """

    def __init__(self, leasing: Leasing) -> None:
        self._leasing = leasing
        self._began = time.monotonic()
        self._unreached = 0  # consecutive attempts without an answer of a node
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
        """Report the reason of the wait, if it has changed."""
        self._unreached = 0 if isinstance(obstacle, RobotsBusy) else self._unreached + 1
        if self.reported != (reason := str(obstacle)):
            self.reported = reason
            if self._leasing.on_wait is not None:
                self._leasing.on_wait(reason)

    def pause(self) -> float:
        """Draw the time until the next attempt [s]; it doubles while a node does not answer, up to a bound."""
        drawn = random.uniform(*RETRY)  # noqa: S311 - not a secret
        longer = min(drawn * 2.0 ** min(self._unreached, 10), MAX_RETRY)
        return min(longer, max(self._left, drawn))
