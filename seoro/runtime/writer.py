"""Writing to files and terminals beside a run: what is slow to take it must not hold up robots.

Items are put down in memory, and encoded and written by a thread. `PERIOD` after an item was put down it is on its
way to the operating system, so that a run that is killed loses hardly more than that. Nothing is dropped: a file
that takes less than a run gives lets items pile up to `MOST_WAITING`, and beyond that the writer gives up with an
error. What waits when a run is over is written before `finish` returns.
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

PERIOD: Final = 0.1  # [s] of the machine's clock, from an item to the write that contains it
MOST_WAITING: Final = 200_000  # items; a record of a trace takes about 1 KB while it waits
_RETRY: Final = 0.01  # [s]
_AT_ONCE: Final = 1000  # items that are encoded for one write

Item = TypeVar("Item")


class ByteSink(Protocol):
    """A file that takes bytes, perhaps not all at once."""

    def write(self, data: memoryview, /) -> int | None:
        """Returns how many it took; None or 0 if it can take none at present."""
        ...


def unbuffered(file: TextIO) -> ByteSink:
    """What a text file writes to, without its buffers, which are to be empty; those of tests may have none."""
    raw: ByteSink = getattr(file.buffer, "raw", file.buffer)
    return raw


class Writer(Generic[Item]):
    """Writes items to a file in a thread of its own, which ends with `finish`, or with the process.

    Args:
        file: Takes the bytes, without a buffer: one that waits with its lock held would keep the process alive.
        name: Of the file, for messages.
        encode: Turns an item into bytes, in the thread: items must not change once they were given.
        most_waiting: How many items may wait.

    `on_error` is called in the thread when something cannot be written.
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
        self._is_idle = True  # whether the thread has to be told of what comes
        self._something = threading.Event()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._has_ended = False
        self._on_end: Callable[[], object] | None = None
        self.on_error: Callable[[Exception], object] = lambda error: None

    def put(self, item: Item) -> None:
        """Give an item to be written; takes no longer than to note it down.

        Raises:
            OSError: An earlier one could not be written, or too many wait.
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
        """How many items wait."""
        return len(self._waiting)

    async def finish(self) -> None:
        """Wait until everything is written; nothing more is to be given.

        Raises:
            OSError: Something could not be written.
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
                is_last = self._closing.wait(PERIOD)  # others follow soon, and are written together
                self._is_idle = True  # first: what comes while the rest is written is not overlooked
                self._write_waiting()
        except Exception as error:
            self._error = self._explained(error)
            self._waiting.clear()
            with suppress(RuntimeError):  # the loop is closed
                self.on_error(self._error)
        self._has_ended = True  # first: who does not see it yet has given what is to be told
        if self._on_end is not None:
            with suppress(RuntimeError):  # the loop is closed: nobody waits any more
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
                    time.sleep(_RETRY)  # someone has made the terminal one that does not block

    def _explained(self, error: Exception) -> Exception:
        if not isinstance(error, OSError):
            return error
        reason = "nobody reads it any more" if isinstance(error, BrokenPipeError) else error.strerror
        return OSError(error.errno, reason, self._name)
