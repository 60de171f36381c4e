"""Records in blocks, so that a page shows any record without reading all of them.

A block is ranges of the trace. Its lines are read and compressed when a page asks for them.
"""

from __future__ import annotations

import re
import zlib
from array import array
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

from seoro.report.columns import Packed, small

ReadAt: TypeAlias = Callable[[int, int], bytes]  # bytes of a trace, by their offset and number

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


@dataclass(frozen=True)
class Block:
    """Ranges of a trace that have the lines of a block.

    Args:
        ranges: Start and end of each range, in turn [bytes].
        head: First line; empty if it is that of the trace.
    """

    ranges: Sequence[int]
    head: bytes = b""

    def compressed(self, read: ReadAt) -> bytes:
        """Compress the lines without wall times and numbers that count on, which would take half of the space.

        Args:
            read: Reads the trace.
        """
        bounds = zip(self.ranges[::2], self.ranges[1::2], strict=True)
        parts = [read(start, end - start) for start, end in bounds]
        if self.head:
            _, line_break, rest = parts[0].partition(b"\n")
            parts[0] = self.head + line_break + rest
        # First lines of ranges lose only the wall time. Without it, they do not match `_HEAD`.
        lines = b"\n".join(map(_without_first_wall, parts))
        return zlib.compress(b"".join(_HEAD.split(lines)), _LEVEL)


class Blocks:
    """All blocks of a trace.

    Attributes:
        head: First line; empty if it is that of the trace.
    """

    def __init__(self) -> None:
        self.head = b""
        self._firsts: list[tuple[int, float, int]] = []  # seq, time and position of the first record of each block
        self._ranges: list[array[int]] = []  # of each block; the last one has no end
        self._kinds = small()
        self._seq = -1  # of the last record
        self._end = -1  # of its line
        self._most_lines = 0  # where the last block ends
        self._most_bytes = 0  # the same [bytes]

    def add(self, start: int, end: int, seq: int, time: float, kind: int) -> None:
        """Append a line.

        Args:
            start: Its start in the trace [bytes].
            end: Its end, without the line break [bytes].
            seq: Number of the record.
            time: Its time [s].
            kind: Number of its kind in `KINDS`.
        """
        kinds = self._kinds
        is_next = start == self._end + 1 and seq == self._seq + 1
        if not is_next or len(kinds) >= self._most_lines or start > self._most_bytes:
            self._begin_range(start, seq, time)
        kinds.append(kind)
        self._seq, self._end = seq, end

    def _begin_range(self, start: int, seq: int, time: float) -> None:
        lines = len(self._kinds)
        if self._ranges:
            self._ranges[-1].append(self._end)
            self._most_bytes += start - self._end  # lines that are left out do not count
        if lines >= self._most_lines or start > self._most_bytes:
            self._most_lines, self._most_bytes = lines + _LINES, start + _BYTES
            self._firsts.append((seq, time, lines))
            self._ranges.append(array("q"))
        self._ranges[-1].append(start)

    def pack(self, packed: Packed) -> list[list[Any]]:
        """Append the column with the kinds.

        Returns:
            First `seq`, first time, number of lines and number of each block that is new or may have grown.
        """
        packed.add_table("records", [("kind", self._kinds)])
        known = packed.start("blocks")
        packed.position["blocks"] = max(len(self._firsts) - 1, 0)
        positions = [*(position for _, _, position in self._firsts), len(self._kinds)]
        return [
            [seq, time, positions[number + 1] - position, number]
            for number, (seq, time, position) in enumerate(self._firsts[known:], known)
        ]

    def __getitem__(self, number: int) -> Block:
        """Return a block until now.

        Raises:
            IndexError: The block does not exist.
        """
        ranges = self._ranges[number]
        ends = (self._end,) if len(ranges) % 2 else ()
        return Block((*ranges, *ends), b"" if number else self.head)

    def __iter__(self) -> Iterator[Block]:
        """Yield all blocks."""
        return map(self.__getitem__, range(len(self._ranges)))


def _without_first_wall(lines: bytes) -> bytes:
    first, line_break, rest = lines.partition(b"\n")
    return _WALL.sub(b"", first, 1) + line_break + rest
