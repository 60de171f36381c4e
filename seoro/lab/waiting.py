"""Waiting until the robots that a run needs are free."""

from __future__ import annotations

import random
import time
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import replace
from typing import TypeVar

import anyio

from seoro.bridges.robot.connecting import Claim, RobotsTaken
from seoro.embed.options import Leasing

RETRY = (0.15, 0.35)  # [s] between two attempts, drawn so that two who want the same do not meet again and again

T = TypeVar("T")


@asynccontextmanager
async def when_free(
    leasing: Leasing, opening: Callable[[Claim], AbstractAsyncContextManager[T]]
) -> AsyncIterator[T]:
    """Have what a run needs for as long as the block lasts, as soon as nobody else has it, if the run waits.

    Args:
        leasing: How the run claims robots, and for how long it waits.
        opening: Opens all of it, or raises `RobotsTaken`.

    Raises:
        RobotsTaken: Others have something of it, still.
    """
    claim = Claim(lease=leasing.lease, priority=leasing.priority)
    began, said = time.monotonic(), ""
    async with AsyncExitStack() as stack:
        while True:
            # The last attempt gives up the place in line.
            waits = leasing.wait is not None and time.monotonic() - began < leasing.wait
            try:
                opened = await stack.enter_async_context(opening(replace(claim, waits=waits)))
                break
            except RobotsTaken as taken:
                if not waits:
                    raise
                if said != (said := str(taken)) and leasing.say is not None:
                    leasing.say(said)
            await anyio.sleep(random.uniform(*RETRY))  # noqa: S311 - nobody gains from guessing it
        if said and leasing.turn is not None:
            await leasing.turn()
        yield opened
