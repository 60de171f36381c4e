"""Observer of a run of a campaign: samples of items, a hash of the trace, and the trace if it may be kept."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import IO, Any

from seoro.campaign.work.measurements import of_item
from seoro.runtime.trace.jsonl import to_line

IN_MEMORY = 4 << 20  # [bytes] of a trace, before it goes to a file


def lasting_part(record: dict[str, Any], line: bytes) -> bytes:
    """Return the part of a line of a trace that is equal in equal runs: without times of the machine.

    Args:
        record: The record.
        line: The record as a line.
    """
    if record["kind"] == "run.end":  # has the wall time of clean-ups
        line = to_line({**record, "cancelled": None})
    return line[:-1].replace(record["wall"].encode(), b"", 1)


class Watching:
    """Observes one run; close it at the end.

    Args:
        path: File for the trace; None if it is not wanted.
    """

    def __init__(self, path: Path | None) -> None:
        self.samples: dict[str, Any] = {}  # last sample of each item, by column
        self._path = path
        self._file: IO[bytes] | None = None
        self._lines: list[bytes] = []
        self._size = 0
        self._hash = hashlib.sha256()

    def record(self, record: dict[str, Any]) -> None:
        """Receive a record."""
        if record["kind"] in ("cover", "record"):
            self.samples.update(of_item(record))
        line = to_line(record)
        self._hash.update(lasting_part(record, line))
        if self._path is not None:
            self._lines.append(line)
            self._size += len(line)
            if self._size > IN_MEMORY:
                self._flush(self._path)

    @property
    def digest(self) -> str:
        """SHA-256 of the trace, without times of the machine."""
        return self._hash.hexdigest()

    def save(self) -> None:
        """Write the trace to its file.

        Raises:
            OSError: The file cannot be written.
        """
        assert self._path is not None, "the trace is wanted"
        self._flush(self._path)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def _flush(self, path: Path) -> None:
        if self._file is None:
            self._file = path.open("wb", buffering=0)
        self._file.write(b"".join(self._lines))
        self._lines.clear()
        self._size = 0
