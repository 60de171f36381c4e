"""Records in compressed blocks, so that a page shows any record without reading all of them."""

from __future__ import annotations

import zlib
from typing import Any, Final

from seoro.report.columns import Packed, small

_LINES: Final = 2_000  # of a block
_BYTES: Final = 1 << 20  # [bytes] of a block before compression; longer lines have their own blocks
_LEVEL: Final = 5  # of compression: higher ones take much longer and save little
KINDS: Final = (
    "other",
    "run.start",
    "run.end",
    "behavior.start",
    "behavior.end",
    "behavior.cancel",
    "attempt.start",
    "attempt.end",
    "instance",
    "event",
    "variable",
    "log.debug",
    "log.info",
    "log.warning",
    "log.error",
    "cover",
    "record",
    "margin",
)
_NUMBERS: Final = {kind: number for number, kind in enumerate(KINDS)}
_WALL: Final = b', "wall": "'


class Blocks:
    """Lines of a trace.

    Attributes:
        blocks: Compressed blocks (zlib).
        directory: First `seq`, first time and number of lines of each block.
    """

    def __init__(self) -> None:
        self.blocks: list[bytes] = []
        self.directory: list[list[Any]] = []
        self._kinds = small()
        self._lines: list[bytes] = []
        self._size = 0

    def add(self, line: bytes, seq: int, time: float, kind: str) -> None:
        """Append a line.

        Args:
            line: JSON without a line break.
            seq: Number of the record.
            time: Its time [s].
            kind: Its kind; for logs with the level, such as `log.info`.
        """
        if self._lines and (len(self._lines) >= _LINES or self._size + len(line) > _BYTES):
            self._close()
        if not self._lines:
            self.directory.append([seq, time, 0])
        self._kinds.append(_NUMBERS.get(kind, 0))
        self._lines.append(without_wall(line))
        self._size += len(line)

    def finish(self, packed: Packed) -> None:
        """Close the last block, and append the column with the kinds."""
        if self._lines:
            self._close()
        packed.add("records.kind", self._kinds)

    def _close(self) -> None:
        self.directory[-1][2] = len(self._lines)
        self.blocks.append(zlib.compress(b"\n".join(self._lines), _LEVEL))
        self._lines.clear()
        self._size = 0


def without_wall(line: bytes) -> bytes:
    """Remove the wall time, which takes more space than the rest of a compressed line."""
    start = line.find(_WALL, 0, 100)  # of the fields before: numbers
    end = line.find(b'"', start + len(_WALL)) if start >= 0 else -1
    return line[:start] + line[end + 1 :] if end >= 0 else line
