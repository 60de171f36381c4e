"""Who holds the robots of a node, and what happens when a holder gives no sign of life."""

from __future__ import annotations

import logging
import time
from collections.abc import AsyncIterator, Awaitable, Callable

import anyio

from seoro.bridges import wire
from seoro.bridges.wire import HOLD_DEADLINE, Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.changes import Changes

ARRIVED = 0.01  # [s] for a sign of life that has arrived to be read, where it is this process that is slow

log = logging.getLogger(__name__)

Stop = Callable[[str], Awaitable[None]]
"""Stops all robots for a reason, and ends their goals as aborted."""


class Hold:
    """The hold on robots, by one client at a time.

    Args:
        stop: Called when the holder gives no sign of life any more.
    """

    def __init__(self, stop: Stop) -> None:
        self._stop = stop
        self._holder: wire.Holder | None = None
        self._alive = False
        self._stopping = False
        self._last = 0.0  # sign of life, by the machine's clock [s]
        self._changes = Changes()

    @property
    def holder(self) -> wire.Holder | None:
        """The client that holds the robots and is alive."""
        return self._holder if self._alive else None

    def take(self, holder: wire.Holder) -> None:
        """Let a client have the robots.

        Raises:
            RequestRefused: Another has them.
        """
        if self._alive and self._holder is not None and self._holder.holder != holder.holder:
            raise RequestRefused(
                Result.INCORRECT_STATE, f"the robots are held by {_called(self._holder)}: wait for its end"
            )
        self._holder = holder
        self._note_life()

    def renew(self, holder: str) -> None:
        """A sign of life.

        Raises:
            RequestRefused: The client does not hold the robots.
        """
        if not self.is_of(holder):
            now = (
                f"{_called(self._holder)} holds them" if self._holder is not None else "this node was started anew"
            )
            raise RequestRefused(Result.INCORRECT_STATE, f"the robots are not held by this run any more: {now}")
        self._note_life()

    def check(self) -> None:
        """Refuse what moves robots when nobody holds them, or they are being stopped."""
        if self._stopping or not self._alive:
            raise RequestRefused(Result.INCORRECT_STATE, "nobody holds the robots: take them first")

    def is_of(self, holder: str) -> bool:
        """Whether a client holds the robots, alive or not."""
        return self._holder is not None and self._holder.holder == holder

    def release(self) -> None:
        """The end of a hold."""
        self._holder, self._alive = None, False
        self._changes.tell()

    def _note_life(self) -> None:
        self._last, self._alive = time.monotonic(), True
        self._changes.tell()

    async def watch_deadline(self) -> None:
        """Stop the robots when a sign of life is overdue; runs as long as the node."""
        while True:
            await self._changes.wait_for(lambda: self._alive)
            if self._left > 0.0:
                await anyio.sleep(self._left)
            else:
                await anyio.sleep(ARRIVED)
                if self._alive and self._left <= 0.0:
                    await self._lapse(f"no sign of life for {HOLD_DEADLINE:g} s")

    @property
    def _left(self) -> float:
        """How long there may be no sign of life [s]."""
        return self._last + HOLD_DEADLINE - time.monotonic()

    async def watch_tokens(self, tokens: AsyncIterator[tuple[str, bool]], namespace: str) -> None:
        """Stop the robots when the holder's token is gone, which is as soon as its process has died."""
        async for token, alive in tokens:
            holder = self.holder
            if not alive and holder is not None and token == wire.holder_token(namespace, holder.holder):
                await self._lapse("its process has died, or the connection to it is lost")

    async def _lapse(self, why: str) -> None:
        assert self._holder is not None
        self._alive, self._stopping = False, True
        reason = f"the robots were stopped, {_called(self._holder)}: {why}"
        log.warning("%s", reason)
        try:
            await self._stop(reason)
        finally:
            self._stopping = False


def _called(holder: wire.Holder) -> str:
    return holder.purpose or f"the client '{holder.holder}'"
