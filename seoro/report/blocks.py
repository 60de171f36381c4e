"""Records in compressed blocks, so that a page shows any record without reading all of them."""

from __future__ import annotations

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
_NUMBERS: Final = {kind: number for number, kind in enumerate(KINDS)}
_WALL: Final = b', "wall": "'


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
            self._firsts.append((seq, time))
        self._kinds.append(_NUMBERS.get(kind, 0))
        self._lines.append(without_wall(line))
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
        return zlib.compress(b"\n".join(self._lines), _LEVEL)


def without_wall(line: bytes) -> bytes:
    """Remove the wall time, which takes more space than the rest of a compressed line."""
    start = line.find(_WALL, 0, 100)  # of the fields before: numbers
    end = line.find(b'"', start + len(_WALL)) if start >= 0 else -1
    return line[:start] + line[end + 1 :] if end >= 0 else line
