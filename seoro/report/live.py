"""A run that is shown while its trace grows."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from seoro.report.blocks import ReadAt
from seoro.report.columns import BEGIN, Position
from seoro.report.folder import Results, results_of
from seoro.report.frames import Frame, status_of
from seoro.report.index import LEVEL, Index
from seoro.report.reading import Reading


@dataclass(frozen=True)
class Cursor:
    """State of a page.

    Args:
        run: Number of the run, which counts restarts.
        version: Version of the data.
        position: Position of the last frame.
    """

    run: int
    version: int
    position: Position


class LiveRun:
    """Data of a run for any number of pages, without a trace until `restart`. Threads may share it."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._read: ReadAt = _no_trace
        self._run = 0
        self._version = 0
        self._reading = Reading()
        self._results = Results()
        self._index: Index | None = None

    @property
    def status(self) -> str:
        """Status as the trace has it; `running` or `killed` without an end."""
        return status_of(self._reading) if self._index is None else self._index.status

    @property
    def is_finished(self) -> bool:
        """Whether no more data is expected."""
        return self._index is not None or self._reading.is_finished

    def feed(self, data: bytes) -> None:
        """Add the next piece of the trace, which may end anywhere."""
        with self._lock:
            self._version += 1
            self._reading.feed(data)

    def finish(self, folder: Path | None = None) -> None:
        """Mark the trace as complete; a run without an end was killed.

        Args:
            folder: Folder with other results of the run; None for none.
        """
        with self._lock:
            self._version += 1
            self._reading.finish()
            self._results = results_of(folder, self._reading)

    def restart(self, read: ReadAt) -> None:
        """Forget all data, since the trace was opened or replaced. Pages receive first frames.

        Args:
            read: Reads the new trace.
        """
        with self._lock:
            self._read = read
            self._run += 1
            self._version += 1
            self._reading = Reading()
            self._results = Results()
            self._index = None

    def save(self) -> Index:
        """Return all data of a finished run."""
        compressor, parts = zlib.compressobj(LEVEL), list[bytes]()
        self.write_frame(lambda data: parts.append(compressor.compress(data)))
        frame = b"".join((*parts, compressor.flush()))
        with self._lock:
            return Index(self.status, frame, list(self._reading.blocks))

    def load(self, index: Index) -> None:
        """Take the data of a finished run instead of reading its trace."""
        with self._lock:
            self._version += 1
            self._index = index

    def is_current(self, cursor: Cursor | None) -> bool:
        """Return whether a page has all data."""
        return cursor is not None and cursor.version == self._version

    def write_frame(self, write: Callable[[bytes], object], cursor: Cursor | None = None) -> Cursor:
        """Write the changes for a page.

        Args:
            write: Receives the parts of the frame: the columns in the order of the field `layout` of its JSON
                object, the object, and its length (4 bytes, little-endian). The first frame of a long run is
                large: files should hold it.
            cursor: State of the page; None for an empty one.

        Returns:
            State of the page with the frame.
        """
        with self._lock:
            if self._index is not None:
                self._index.write_frame(write)
                return Cursor(self._run, self._version, BEGIN)
            since = cursor.position if cursor is not None and cursor.run == self._run else BEGIN
            frame = Frame(self._reading, self._results, write, since)
            write(frame.text)
            write(len(frame.text).to_bytes(4, "little"))
            return Cursor(self._run, self._version, frame.position)

    def block(self, number: int) -> bytes:
        """Return the lines of a block, compressed; the last one may grow.

        Raises:
            IndexError: The block does not exist.
            OSError: The trace cannot be read.
        """
        if number < 0:
            raise IndexError(number)
        with self._lock:
            blocks = self._reading.blocks if self._index is None else self._index.blocks
            found, read = blocks[number], self._read
        return found.compressed(read)


def _no_trace(start: int, size: int) -> bytes:
    return b""
