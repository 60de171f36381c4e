"""Positions of the protocol and offsets into texts.

The protocol counts lines from 0, and characters in units of an encoding that client and server agree on: UTF-16
unless the client offers another. Offsets count code points, as everywhere else in seoro.
"""

from __future__ import annotations

from bisect import bisect_left
from itertools import accumulate

from lsprotocol.types import Position, Range
from pygls.workspace import PositionCodec

from seoro.lang.source import SourceFile, Span


class Positions:
    """Translates between positions and offsets.

    Args:
        codec: Encoding of the protocol's characters.
    """

    def __init__(self, codec: PositionCodec) -> None:
        self._codec = codec

    def position(self, file: SourceFile, offset: int) -> Position:
        """Return the position of an offset, limited to the end of the text."""
        line, column = file.position(min(offset, len(file.text)))
        before = file.line(line)[: column - 1]
        # An offset between CR and LF is at the end of its line.
        return Position(line - 1, len(before) if before.isascii() else self._codec.client_num_units(before))

    def range(self, span: Span) -> Range:
        """Return the range of a span."""
        return Range(self.position(span.file, span.start), self.position(span.file, span.end))

    def offset(self, file: SourceFile, position: Position) -> int:
        """Return the offset of a position, limited to its line and the text."""
        if position.line < 0:
            return 0
        if position.line >= file.line_count:
            return len(file.text)
        text = file.line(position.line + 1)
        ends = list(accumulate(map(self._codec.client_num_units, text), initial=0))
        return file.start_of_line(position.line + 1) + min(bisect_left(ends, position.character), len(text))
