"""Trace file that is read while it grows."""

from __future__ import annotations

import os
from io import BufferedReader
from pathlib import Path
from typing import Final

from seoro.files.inputs import Kind, open_input
from seoro.report.live import LiveRun

_PIECE: Final = 1 << 20  # [bytes] of one call of `poll`
_HEAD: Final = 4096  # [bytes] by which a file that was written anew is recognised


class TraceFile:
    """Reads a trace into a `LiveRun`; starts again if the file was truncated, replaced or written anew.

    Args:
        path: The file; it may be created later.
        run: Run that receives its data.
    """

    def __init__(self, path: Path, run: LiveRun) -> None:
        self.path = path
        self._run = run
        self._file: BufferedReader | None = None
        self._head = b""
        self._offset = 0

    def poll(self) -> bool:
        """Read the next piece; returns whether there was one.

        Raises:
            OSError: The file cannot be read. A missing file is empty.
        """
        try:
            file = self._opened()
        except FileNotFoundError:
            return False
        data = os.pread(file.fileno(), _PIECE, self._offset)
        if not data:
            return False
        if len(self._head) < _HEAD:
            self._head = os.pread(file.fileno(), _HEAD, 0)[: self._offset + len(data)]
        self._offset += len(data)
        self._run.feed(data)
        return True

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _opened(self) -> BufferedReader:
        found = self.path.stat()
        if self._file is not None:
            current = os.fstat(self._file.fileno())
            is_same = os.path.samestat(found, current) and current.st_size >= self._offset
            if is_same and os.pread(self._file.fileno(), len(self._head), 0) == self._head:
                return self._file
            self.close()
            self._head, self._offset = b"", 0
            self._run.restart()
        self._file = open_input(self.path, Kind.TRACE)
        return self._file
