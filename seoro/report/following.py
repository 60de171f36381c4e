"""Trace file that is read while it grows."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from threading import Lock
from typing import IO, Final

from seoro.files.inputs import Kind, open_input
from seoro.report.index import load, place_of, store
from seoro.report.live import LiveRun

_PIECE: Final = 1 << 20  # [bytes] of one call of `poll`
_HEAD: Final = 4096  # [bytes] by which a file that was written anew is recognised


class OpenTrace:
    """Bytes of an open trace, for any thread."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._lock = Lock()

    def read_at(self, start: int, size: int) -> bytes:
        """Return a part of the trace; less at its end.

        Raises:
            OSError: It cannot be read, or is closed.
        """
        with self._lock:
            if self._file.closed:
                raise OSError(errno.EBADF, "the trace was replaced")
            return os.pread(self._file.fileno(), size, start)

    def stat(self) -> os.stat_result:
        """Return the state of the file."""
        return os.fstat(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._file.close()


class TraceFile:
    """Reads a trace into a `LiveRun`; starts again if the file was truncated, replaced or written anew.

    Args:
        path: The file; it may be created later.
        run: Run that receives its data.
        folder: Folder with other results of the run; None for none.
    """

    def __init__(self, path: Path, run: LiveRun, folder: Path | None = None) -> None:
        self.path = path
        self._run = run
        self._folder = folder
        self._is_loaded = False  # from the cache
        self._file: OpenTrace | None = None
        self._head = b""
        self._offset = 0

    def poll(self) -> bool:
        """Read the next piece, or a finished run from the cache; returns whether there was anything.

        Raises:
            OSError: The file cannot be read. A missing file is empty.
        """
        try:
            file = self._opened()
        except FileNotFoundError:
            return False
        if self._offset == 0 and self._load(file):
            return True
        data = file.read_at(self._offset, _PIECE)
        if not data:
            return False
        self._advance(file, len(data))
        self._run.feed(data)
        return True

    def finish(self) -> None:
        """Mark the trace as complete, and keep its data in the cache."""
        if self._run.is_finished:
            return
        self._run.finish(self._folder)
        place = place_of(self.path, self._folder)
        if place is not None and self._file is not None and self._file.stat().st_size == self._offset:
            store(place, self._run.save())

    def _load(self, file: OpenTrace) -> bool:
        size = file.stat().st_size
        place = place_of(self.path, self._folder)
        index = None if place is None else load(place)
        if index is None:
            return False
        self._advance(file, size)
        self._is_loaded = True
        self._run.load(index)
        return True

    def _advance(self, file: OpenTrace, size: int) -> None:
        if len(self._head) < _HEAD:
            self._head = file.read_at(0, min(_HEAD, self._offset + size))
        self._offset += size

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _opened(self) -> OpenTrace:
        found = self.path.stat()
        if self._file is not None:
            current = self._file.stat()
            # Data from the cache is complete and cannot grow.
            size, least = current.st_size, self._offset
            is_same = os.path.samestat(found, current) and (size == least if self._is_loaded else size >= least)
            if is_same and self._file.read_at(0, len(self._head)) == self._head:
                return self._file
            self.close()
            self._head, self._offset, self._is_loaded = b"", 0, False
        self._file = OpenTrace(open_input(self.path, Kind.TRACE))
        self._run.restart(self._file.read_at)
        return self._file
