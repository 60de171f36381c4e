"""Positions in source text: files, spans, lines and columns.

All nodes of trees and plans and all messages have a `Span`. So errors of checks and of runs can show the text of
the scenario.
"""

from __future__ import annotations

import hashlib
import re
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Final

from seoro.lang.frozen import Value

# `str.splitlines` would also split at form feeds and Unicode separators.
_LINE_END: Final = re.compile(r"\r\n?|\n")


@dataclass(frozen=True, eq=False)
class SourceFile:
    """A source text.

    Args:
        name: Name in messages.
        text: Decoded content, with the line ends of the file.
        path: Path of the file; None for other text, such as a command-line option.
    """

    name: str
    text: str = field(repr=False)
    path: Path | None = None

    @cached_property
    def _line_starts(self) -> tuple[int, ...]:
        """Offsets of line starts; CR, LF and CRLF end a line (7.2.1.2)."""
        return (0, *(found.end() for found in _LINE_END.finditer(self.text)))

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the text in UTF-8."""
        return hashlib.sha256(self.text.encode("utf-8", "surrogatepass")).hexdigest()

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column of an offset, both from 1."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def start_of_line(self, number: int) -> int:
        """Return the offset of the start of a line (from 1)."""
        return self._line_starts[number - 1]

    def line(self, number: int) -> str:
        """Return the text of a line (from 1), without its end."""
        start = self._line_starts[number - 1]
        end = self._line_starts[number] if number < len(self._line_starts) else len(self.text)
        return self.text[start:end].rstrip("\r\n")

    @property
    def line_count(self) -> int:
        """Number of lines; an empty last line counts."""
        return len(self._line_starts)


class Span(Value):
    """A section of a source file: offsets `start` (included) to `end` (excluded)."""

    file: SourceFile
    start: int
    end: int

    @property
    def line(self) -> int:
        """Line of the start, from 1."""
        return self.file.position(self.start)[0]

    @property
    def column(self) -> int:
        """Column of the start, from 1."""
        return self.file.position(self.start)[1]

    @property
    def text(self) -> str:
        """Text of the span."""
        return self.file.text[self.start : self.end]

    def to(self, other: Span) -> Span:
        """Return the span from the start of this one to the end of the other."""
        return Span(self.file, self.start, other.end)

    def head(self, word: str) -> Span:
        """Return the span of the first word of a statement, for messages about the whole statement."""
        return Span(self.file, self.start, min(self.start + len(word), self.end))

    def __str__(self) -> str:
        line, column = self.file.position(self.start)
        return f"{self.file.name}:{line}:{column}"
