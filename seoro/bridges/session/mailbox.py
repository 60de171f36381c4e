"""Bounded queue from Zenoh's threads to the event loop.

A mailbox is bounded: a slow reader must neither exhaust the memory nor block Zenoh's callbacks, which would delay
everything on the same link. Messages beyond the bound are dropped by its policy (`Bound`) and counted. The loop is
woken only for a waiting reader, and once for all messages that arrived before it runs, since a wake-up costs more
than a message.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Generic, Literal, Self, TypeVar

from seoro.deferred import dataclass

T = TypeVar("T")

MEBIBYTE = 1 << 20


class Closed(Exception):
    """The mailbox is closed and empty."""


@dataclass(frozen=True)
class Bound:
    """Capacity of a mailbox, and the policy for more messages.

    Attributes:
        count: Limit of the number of unread messages.
        size: Limit of their total size [bytes]; a single message may be larger.
        drop: Messages to drop: the oldest unread ones, or new ones.
    """

    count: int
    size: int = 256 * MEBIBYTE
    drop: Literal["oldest", "newest"] = "oldest"

    def __post_init__(self) -> None:
        if self.count < 1 or self.size < 1:
            raise ValueError(
                f"invalid capacity of {self.count} messages and {self.size} bytes; expected at least 1 of each"
            )


LATEST = Bound(1)  # for receivers of a state, which need no history


class Mailbox(Generic[T]):
    """Messages from other threads for one event loop, which is running when the mailbox is created."""

    def __init__(self, bound: Bound) -> None:
        self._bound = bound
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._waiting: deque[tuple[T, int]] = deque()
        self._size = 0
        self.dropped = 0  # number of messages so far
        self._waking = False
        self._closed = False
        self._calls: dict[Callable[[], None], None] = {}  # callbacks of the next arrival

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: T, size: int) -> bool:
        """Add a message of `size` [bytes], from any thread and without waiting. False if it was dropped."""
        with self._lock:
            if self._closed:
                return False
            if self._bound.drop == "newest" and self._is_full(size):
                self.dropped += 1
                return False
            while self._waiting and self._is_full(size):
                self._size -= self._waiting.popleft()[1]
                self.dropped += 1
            self._waiting.append((message, size))
            self._size += size
            if self._waking or not self._calls:
                return True
            self._waking = True
        with suppress(RuntimeError):  # the loop may be closed at the end of the process
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

    async def get(self) -> T:
        """Wait for the oldest message, and return it.

        Other tasks get a turn even if a message is present, so that a reader with a backlog does not starve them.

        Raises:
            Closed: The mailbox is closed and empty.
        """
        if self._waiting:
            await asyncio.sleep(0)
        while (message := self.get_nowait()) is None:
            if self._closed:
                raise Closed
            arrived = self._loop.create_future()
            wake = partial(_settle, arrived)
            self.on_arrival(wake)
            try:
                await arrived
            finally:
                self._calls.pop(wake, None)
        return message

    def on_arrival(self, call: Callable[[], None]) -> None:
        """Call `call` once on the loop's thread, soon after a message arrives or the mailbox closes.

        A callback needs fewer turns of the loop than a waiting task.
        """
        with self._lock:  # a message that arrives meanwhile is seen here, or sees the callback
            if not self._waiting and not self._closed:
                self._calls[call] = None
                return
        self._loop.call_soon(call)

    def get_nowait(self) -> T | None:
        """Return the oldest message, or None if the mailbox is empty."""
        with self._lock:
            if not self._waiting:
                return None
            message, size = self._waiting.popleft()
            self._size -= size
            return message

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        try:
            return await self.get()
        except Closed:
            raise StopAsyncIteration from None

    def close(self) -> None:
        """Accept no more messages. Call it on the loop's thread. Unread messages can still be taken."""
        with self._lock:
            self._closed = True
        self._loop.call_soon(self._wake)


def _settle(future: asyncio.Future[None]) -> None:
    if not future.done():
        future.set_result(None)
