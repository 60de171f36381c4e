"""Where things stand in source text: files, spans, lines and columns.

Every node of the tree, every node of the plan and every message holds a `Span`, so that whatever goes
wrong, at check time or in the middle of a run, can be shown in the scenario's own text.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Final

from seoro.lang.frozen import Value

# str.splitlines would also break at form feeds and Unicode separators, which end no OSC line.
_LINE_END: Final = re.compile(r"\r\n?|\n")


@dataclass(frozen=True, eq=False)
class SourceFile:
    """One text that was read.

    Args:
        name: How the user named it; shown in messages.
        text: Its content, decoded, with line ends as they are in the file.
        path: Where it lies; None for text that came from elsewhere, such as a command-line option.
    """

    name: str
    text: str = field(repr=False)
    path: Path | None = None

    @cached_property
    def _line_starts(self) -> tuple[int, ...]:
        """Offsets at which lines begin; CR, LF and CRLF end a line (7.2.1.2)."""
        return (0, *(found.end() for found in _LINE_END.finditer(self.text)))

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset into the text, both from 1."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def start_of_line(self, number: int) -> int:
        """Offset at which a line (from 1) begins."""
        return self._line_starts[number - 1]

    def line(self, number: int) -> str:
        """Text of a line (from 1), without its end."""
        start = self._line_starts[number - 1]
        end = self._line_starts[number] if number < len(self._line_starts) else len(self.text)
        return self.text[start:end].rstrip("\r\n")

    @property
    def line_count(self) -> int:
        """How many lines the text has; an empty last line counts."""
        return len(self._line_starts)


class Span(Value):
    """A stretch of a source file: offsets `start` (included) to `end` (excluded)."""

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
        """The text that is spanned."""
        return self.file.text[self.start : self.end]

    def to(self, other: Span) -> Span:
        """The span from the start of this one to the end of the other."""
        return Span(self.file, self.start, other.end)

    def __str__(self) -> str:
        line, column = self.file.position(self.start)
        return f"{self.file.name}:{line}:{column}"
