"""Writing to files and terminals in a thread: slow ones must not hold up robots.

Items are queued, and encoded and written by a thread. An item is written within about `PERIOD`, so that a killed
run loses hardly more. Nothing is dropped: items queue up for a slow file up to `MOST_WAITING`; then the writer
fails with an error. `finish` returns when all queued items are written.
"""

from __future__ import annotations

import asyncio
import errno
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Final, Generic, Protocol, TextIO, TypeVar

PERIOD: Final = 0.1  # [s] of the machine's clock, from an item to its write
MOST_WAITING: Final = 200_000  # items; a record of a trace takes about 1 KB while it waits
_RETRY: Final = 0.01  # [s]
_AT_ONCE: Final = 1000  # items encoded for one write

Item = TypeVar("Item")


class ByteSink(Protocol):
    """A file that accepts bytes, perhaps not all at once."""

    def write(self, data: memoryview, /) -> int | None:
        """Return the number of accepted bytes; None or 0 for none at present."""


def unbuffered(file: TextIO) -> ByteSink:
    """Return the raw file of a text file, whose buffers must be empty; files of tests may have none."""
    raw: ByteSink = getattr(file.buffer, "raw", file.buffer)
    return raw


class Writer(Generic[Item]):
    """Writes items to a file in a thread of its own, which ends with `finish` or with the process.

    Args:
        file: An unbuffered file: a buffer locked by a blocked write would keep the process alive.
        name: Name of the file, for messages.
        encode: Encodes an item, in the thread; queued items must not change.
        most_waiting: Maximum number of queued items.

    `on_error` is called in the thread for a write error.
    """

    def __init__(
        self, file: ByteSink, name: str, encode: Callable[[Item], bytes], most_waiting: int = MOST_WAITING
    ) -> None:
        self._file = file
        self._name = name
        self._encode = encode
        self._most_waiting = most_waiting
        self._waiting: deque[Item] = deque()
        self._error: Exception | None = None
        self._is_idle = True  # whether the thread must be woken for the next item
        self._something = threading.Event()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._has_ended = False
        self._on_end: Callable[[], object] | None = None
        self.on_error: Callable[[Exception], object] = lambda error: None

    def put(self, item: Item) -> None:
        """Queue an item to be written.

        Raises:
            OSError: An earlier item could not be written, or the queue is full.
        """
        if self._error is not None:
            raise self._error
        self._waiting.append(item)
        if self._is_idle:
            self._is_idle = False
            self._something.set()
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name=f"writes {self._name}", daemon=True)
                self._thread.start()
        elif len(self._waiting) > self._most_waiting:
            self._error = OSError(errno.ENOBUFS, f"it is too slow: {self._most_waiting:,} lines wait", self._name)
            raise self._error

    @property
    def waiting(self) -> int:
        """Number of queued items."""
        return len(self._waiting)

    async def finish(self) -> None:
        """Wait until all items are written; no further items may follow.

        Raises:
            OSError: An item could not be written.
        """
        if self._thread is not None and self._error is None:
            loop, ended = asyncio.get_running_loop(), asyncio.Event()
            self._on_end = partial(loop.call_soon_threadsafe, ended.set)
            self._closing.set()
            self._something.set()
            if not self._has_ended:
                await ended.wait()
        if self._error is not None:
            raise self._error

    def _work(self) -> None:
        try:
            is_last = False
            while not is_last:
                self._something.wait()
                self._something.clear()
                is_last = self._closing.wait(PERIOD)  # further items join this write
                self._is_idle = True  # before the write, so that items that arrive meanwhile are noticed
                self._write_waiting()
        except Exception as error:
            self._error = self._explained(error)
            self._waiting.clear()
            with suppress(RuntimeError):  # the loop is closed
                self.on_error(self._error)
        self._has_ended = True  # first: `finish` then does not wait for the callback
        if self._on_end is not None:
            with suppress(RuntimeError):  # the loop is closed: no task waits
                self._on_end()

    def _write_waiting(self) -> None:
        waiting = self._waiting
        while waiting and self._error is None:
            some = [self._encode(waiting.popleft()) for _ in range(min(len(waiting), _AT_ONCE))]
            rest = memoryview(b"".join(some))
            while rest:
                taken = self._file.write(rest)
                rest = rest[taken or 0 :]
                if not taken:
                    time.sleep(_RETRY)  # the terminal is in non-blocking mode

    def _explained(self, error: Exception) -> Exception:
        if not isinstance(error, OSError):
            return error
        reason = "its reader has closed it" if isinstance(error, BrokenPipeError) else error.strerror
        return OSError(error.errno, reason, self._name)
