"""Pipe from a run to its executor, which does not block the run."""

from __future__ import annotations

import os
import select
import threading
from collections import deque
from itertools import groupby
from typing import Any, Final

from seoro.executor.process.frames import Frame, frame
from seoro.runtime.trace.jsonl import to_line

MAX_RECORDS: Final = 1000  # in one frame

Item = dict[str, Any] | tuple[Frame, bytes]


class TracePipe:
    """Observer of the trace, which writes it to a pipe.

    Records are written at once: a thread would have to wait for the interpreter. If the pipe is full, because the
    executor is blocked or too slow, a thread writes the rest, with many records at a time.

    Args:
        data: Descriptor of the pipe.
    """

    def __init__(self, data: int) -> None:
        os.set_blocking(data, False)
        self._data = data
        self._waiting: deque[Item] = deque()
        self._rest = memoryview(b"")  # of a partly written frame
        self._writing = threading.Lock()
        self._news = threading.Event()
        threading.Thread(target=self._work, name="trace pipe", daemon=True).start()

    def send(self, kind: Frame, data: bytes | str = b"") -> None:
        """Send a frame."""
        self._put((kind, data.encode() if isinstance(data, str) else data))

    def record(self, record: dict[str, Any]) -> None:
        """Send a record of the trace."""
        self._put(record)

    def finish(self, end: bytes) -> None:
        """Send the end of the run, and wait until everything is written."""
        self._waiting.append((Frame.END, end))
        with self._writing:
            self._write_all()

    def _put(self, item: Item) -> None:
        self._waiting.append(item)
        if not self._writing.acquire(blocking=False):
            self._news.set()  # the thread may just have found the queue empty
            return
        try:
            while self._write_some():
                pass
        finally:
            self._writing.release()
        if self._rest:
            self._news.set()

    def _work(self) -> None:
        while True:
            self._news.wait()
            self._news.clear()
            with self._writing:
                self._write_all()

    def _write_all(self) -> None:
        """Write everything, and wait while the pipe is full."""
        poll = select.poll()
        poll.register(self._data, select.POLLOUT)
        while self._rest or self._waiting:
            if not self._write_some():
                poll.poll()

    def _write_some(self) -> bool:
        """Write as much as the pipe accepts; returns whether anything was written."""
        if not self._rest:
            self._rest = memoryview(self._next())
        if not self._rest:
            return False
        try:
            self._rest = self._rest[os.write(self._data, self._rest) :]
        except BlockingIOError:
            return False
        except BrokenPipeError:  # the executor has died, which the other pipe shows
            self._rest = memoryview(b"")
        return True

    def _next(self) -> bytes:
        """Return the next frames."""
        items: list[Item] = []
        while self._waiting and len(items) < MAX_RECORDS:
            items.append(self._waiting.popleft())
        frames = []
        for is_record, group in groupby(items, lambda item: isinstance(item, dict)):
            if is_record:
                lines = b"".join(to_line(item) for item in group if isinstance(item, dict))
                frames.append(frame(Frame.TRACE, lines))
            else:
                frames += [frame(*item) for item in group if isinstance(item, tuple)]
        return b"".join(frames)
