"""Tells the executor what happens in a run, soon and without holding the run up."""

from __future__ import annotations

import os
import select
import threading
from collections import deque
from itertools import groupby
from typing import Any, Final

from seoro.executor.frames import Frame, frame
from seoro.runtime.jsonl import to_line

MOST_AT_ONCE: Final = 1000  # records in one frame

Item = dict[str, Any] | tuple[Frame, bytes]


class Telling:
    """An observer of the trace, which writes it to a pipe.

    Records are written as they are made: a thread would have to wait for the interpreter first. What finds the
    pipe full, because the executor stands still or the run is faster than it can keep, is written by a thread all
    the same, many at a time.

    Args:
        data: Number of the pipe.
    """

    def __init__(self, data: int) -> None:
        os.set_blocking(data, False)
        self._data = data
        self._waiting: deque[Item] = deque()
        self._rest = memoryview(b"")  # of a frame that was written in part
        self._writing = threading.Lock()
        self._news = threading.Event()
        threading.Thread(target=self._work, name="tells the executor", daemon=True).start()

    def wait(self, for_whom: str) -> None:
        """Tell for whom the run waits, before it begins."""
        self._put((Frame.WAITS, for_whom.encode()))

    def be_ready(self) -> None:
        """Tell that the run has what it has waited for."""
        self._put((Frame.READY, b""))

    def begin(self, announcement: str) -> None:
        """Tell what the run begins with."""
        self._put((Frame.BEGIN, announcement.encode()))

    def tried(self, found: bytes) -> None:
        """Tell what a dry run would begin with."""
        self._put((Frame.TRIED, found))

    def record(self, record: dict[str, Any]) -> None:
        """Tell of a record."""
        self._put(record)

    def finish(self, end: bytes) -> None:
        """Tell the end of the run, and wait until everything is told."""
        self._waiting.append((Frame.END, end))
        with self._writing:
            self._write_all()

    def _put(self, item: Item) -> None:
        self._waiting.append(item)
        if not self._writing.acquire(blocking=False):
            self._news.set()  # the thread may just have seen that there was nothing more
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
        """Write everything, waiting for room."""
        room = select.poll()
        room.register(self._data, select.POLLOUT)
        while self._rest or self._waiting:
            if not self._write_some():
                room.poll()

    def _write_some(self) -> bool:
        """Write as much as there is room for; whether anything was written."""
        if not self._rest:
            self._rest = memoryview(self._next())
        if not self._rest:
            return False
        try:
            self._rest = self._rest[os.write(self._data, self._rest) :]
        except BlockingIOError:
            return False
        except BrokenPipeError:  # the executor is gone, which the other pipe tells
            self._rest = memoryview(b"")
        return True

    def _next(self) -> bytes:
        """The frames of what waits."""
        items: list[Item] = []
        while self._waiting and len(items) < MOST_AT_ONCE:
            items.append(self._waiting.popleft())
        frames = []
        for is_record, group in groupby(items, lambda item: isinstance(item, dict)):
            if is_record:
                lines = b"".join(to_line(item) for item in group if isinstance(item, dict))
                frames.append(frame(Frame.TRACE, lines))
            else:
                frames += [frame(*item) for item in group if isinstance(item, tuple)]
        return b"".join(frames)
