"""Positions of the protocol and offsets into texts.

The protocol counts lines from 0, and characters in units of an encoding that client and server agree on: UTF-16
unless the client offers another. Offsets count code points, as everywhere else in seoro.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from lsprotocol.types import Position, PositionEncodingKind, Range

from seoro.lang.source import SourceFile, Span


def _utf8(char: str) -> int:
    point = ord(char)
    return 1 if point < 0x80 else 2 if point < 0x800 else 3 if point < 0x10000 else 4


_WIDTHS: Final[Mapping[str, Callable[[str], int]]] = {
    PositionEncodingKind.Utf8.value: _utf8,
    PositionEncodingKind.Utf16.value: lambda char: 2 if ord(char) > 0xFFFF else 1,
    PositionEncodingKind.Utf32.value: lambda _: 1,
}


class Positions:
    """Translates between positions and offsets.

    Args:
        encoding: Of the protocol's characters: `utf-8`, `utf-16` or `utf-32`.
    """

    def __init__(self, encoding: str = PositionEncodingKind.Utf16.value) -> None:
        self._width = _WIDTHS[encoding]

    def position(self, file: SourceFile, offset: int) -> Position:
        """Return the position of an offset, limited to the end of the text."""
        line, column = file.position(min(offset, len(file.text)))
        before = file.line(line)[: column - 1]
        # An offset between CR and LF is at the end of its line.
        return Position(line - 1, len(before) if before.isascii() else sum(map(self._width, before)))

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
        start = file.start_of_line(position.line + 1)
        if text.isascii():
            return start + max(0, min(position.character, len(text)))
        units = 0
        for index, char in enumerate(text):
            if units >= position.character:
                return start + index
            units += self._width(char)
        return start + len(text)
