"""Records in compressed blocks, so that a page shows any record without reading all of them."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
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
_WALL: Final = re.compile(rb', "wall": "[^"]*"(?=, "kind": )')
_HEAD: Final = re.compile(rb'(\n\{)"seq": \d+, ("t": [^,\n]+, )"wall": "[^"\n]*", (?="kind": )')


class Blocks:
    """Lines of a trace.

    Attributes:
        closed: Compressed blocks (zlib) that no longer grow.
    """

    def __init__(self) -> None:
        self.closed: list[bytes] = []
        self._firsts: list[tuple[int, float]] = []  # number and time of the first record of each block
        self._counts: list[int] = []  # of lines in closed blocks
        self._kinds = small()
        self._lines: list[bytes] = []
        self._next = 0  # number of the next record, unless some are left out
        self._size = 0

    def add(self, line: bytes, seq: int, time: float, kind: int) -> None:
        """Append a line.

        Args:
            line: JSON without a line break.
            seq: Number of the record.
            time: Its time [s].
            kind: Number of its kind in `KINDS`.
        """
        lines = self._lines
        if len(lines) >= _LINES or self._size > _BYTES:
            self._close()
        if not lines:
            self._firsts.append((seq, time))
        self._kinds.append(kind)
        # Numbers that count on are left out with the wall time; all other lines lose only that.
        lines.append(line if seq == self._next and lines else _WALL.sub(b"", line, 1))
        self._next = seq + 1
        self._size += len(line)

    def pack(self, packed: Packed) -> list[list[Any]]:
        """Append the column with the kinds.

        Returns:
            First `seq`, first time, number of lines and number of each block that is new or may have grown.
        """
        packed.add_table("records", [("kind", self._kinds)])
        start = packed.start("blocks")
        packed.position["blocks"] = len(self.closed)
        counts = [*self._counts, len(self._lines)]
        return [[*self._firsts[number], counts[number], number] for number in range(start, len(self._firsts))]

    def compressed(self, number: int) -> bytes:
        """Return the lines of a block until now, compressed.

        Raises:
            IndexError: The block does not exist.
        """
        if not 0 <= number < len(self._firsts):
            raise IndexError(number)
        return self.closed[number] if number < len(self.closed) else self._compress()

    def all(self) -> Iterator[bytes]:
        """Yield all blocks."""
        return map(self.compressed, range(len(self._firsts)))

    def _close(self) -> None:
        self.closed.append(self._compress())
        self._counts.append(len(self._lines))
        self._lines.clear()
        self._size = 0

    def _compress(self) -> bytes:
        """Compress the lines without wall times and numbers that count on, which would take half of the space."""
        return zlib.compress(b"".join(_HEAD.split(b"\n".join(self._lines))), _LEVEL)
