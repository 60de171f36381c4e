"""Changes of sections of a text."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.lang.frozen import Value
from seoro.lang.source import SourceFile


class Edit(Value):
    """Replacement of a section: offsets `start` (included) to `end` (excluded)."""

    start: int
    end: int
    text: str


class Rewriting(Value):
    """Change of a scenario file.

    Args:
        line: Its line, before the changes of the same round of checks.
        title: Description in a few words.
        edits: Its edits, which do not overlap.
    """

    line: int
    title: str
    edits: tuple[Edit, ...]


def apply_edits(text: str, edits: Sequence[Edit]) -> str:
    """Return a text with edits applied."""
    for edit in sorted(edits, key=lambda each: each.start, reverse=True):
        text = f"{text[: edit.start]}{edit.text}{text[edit.end :]}"
    return text


def line_end(file: SourceFile, offset: int) -> int:
    """Return the offset of the end of the line with an offset, before the line break."""
    return file.start_of_line(file.position(offset)[0]) + len(file.line(file.position(offset)[0]))


def line_start(file: SourceFile, offset: int) -> int:
    """Return the offset of the start of the line with an offset."""
    return file.start_of_line(file.position(offset)[0])


def indent_of(file: SourceFile, offset: int) -> str:
    """Return the white space before the text of the line with an offset."""
    line = file.line(file.position(offset)[0])
    return line[: len(line) - len(line.lstrip())]


def line_break(file: SourceFile) -> str:
    """Return the line break that a text uses."""
    return "\r\n" if "\r\n" in file.text else "\n"
