"""Where Zenoh's threads leave what has arrived, and the event loop takes it.

A mailbox is bounded, because a reader that is slower than what arrives must cost neither memory without end nor
the session: a callback of Zenoh's that waits would hold up everything else that comes over the same link. What is
lost instead is said beforehand (`Bound`) and counted. The loop is woken once for all that arrived before it came
to look, since a wake-up costs more than a message.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Generic, Literal, TypeVar

T = TypeVar("T")

MEBIBYTE = 1 << 20


class Closed(Exception):
    """Nothing will arrive any more: what the mailbox belonged to has ended."""


@dataclass(frozen=True)
class Bound:
    """How much a mailbox holds, and what is lost when more arrives.

    Attributes:
        count: Messages that wait at most.
        size: [bytes] that they may have together; a single message may have more.
        lose: Which are lost: the oldest of those that wait, or those that arrive.
    """

    count: int
    size: int = 256 * MEBIBYTE
    lose: Literal["oldest", "newest"] = "oldest"

    def __post_init__(self) -> None:
        if self.count < 1 or self.size < 1:
            raise ValueError(
                f"a mailbox holds at least one message and one byte, not {self.count} and {self.size}"
            )


LATEST = Bound(1)  # for those who want to know how things are, not how they came about


class Mailbox(Generic[T]):
    """Messages from other threads, for one event loop: the one that is running when it is made."""

    def __init__(self, bound: Bound) -> None:
        self._bound = bound
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._waiting: deque[tuple[T, int]] = deque()
        self._size = 0
        self._lost = 0
        self._waking = False
        self._closed = False
        self._calls: dict[Callable[[], None], None] = {}  # for who waits

    @property
    def lost(self) -> int:
        """Messages that nobody could take in time, so far."""
        return self._lost

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: T, size: int) -> bool:
        """Leave a message of `size` [bytes]; from any thread, without ever waiting. False if it is lost itself."""
        with self._lock:
            if self._closed:
                return False
            if self._bound.lose == "newest" and self._is_full(size):
                self._lost += 1
                return False
            while self._waiting and self._is_full(size):
                self._size -= self._waiting.popleft()[1]
                self._lost += 1
            self._waiting.append((message, size))
            self._size += size
            if self._waking:
                return True
            self._waking = True
        with suppress(RuntimeError):  # the loop may be gone when something arrives at the end of the process
            self._loop.call_soon_threadsafe(self._wake)
        return True

    def _is_full(self, size: int) -> bool:
        if not self._waiting:
            return False
        return len(self._waiting) >= self._bound.count or self._size + size > self._bound.size

    def _wake(self) -> None:
        self._waking = False
        calls, self._calls = self._calls, {}
        for call in calls:
            call()

    async def take(self) -> T:
        """The oldest message; waits for one.

        Other tasks get a turn even if a message is there, so that a reader with a backlog does not starve them.

        Raises:
            Closed: There is none, and none will come.
        """
        if self._waiting:
            await asyncio.sleep(0)
        while (message := self.take_now()) is None:
            if self._closed:
                raise Closed
            await self._arrival()
        return message

    async def _arrival(self) -> None:
        arrived = self._loop.create_future()
        wake = partial(_settle, arrived)
        self.when_arrived(wake)
        try:
            await arrived
        finally:
            self._calls.pop(wake, None)

    def when_arrived(self, call: Callable[[], None]) -> None:
        """Have something called once on the loop's thread, soon after there is a message, or there will be none.

        It spares those who are no task of their own the turns of the loop that a task takes.
        """
        if self._waiting or self._closed:
            self._loop.call_soon(call)
        else:
            self._calls[call] = None

    def take_now(self) -> T | None:
        """The oldest message if there is one."""
        with self._lock:
            if not self._waiting:
                return None
            message, size = self._waiting.popleft()
            self._size -= size
            return message

    async def __aiter__(self) -> AsyncIterator[T]:
        with suppress(Closed):
            while True:
                yield await self.take()

    def close(self) -> None:
        """Take nothing in any more, on the loop's thread; what waits can still be taken, and then waiting ends."""
        with self._lock:
            self._closed = True
        self._loop.call_soon(self._wake)


def _settle(future: asyncio.Future[None]) -> None:
    if not future.done():
        future.set_result(None)
