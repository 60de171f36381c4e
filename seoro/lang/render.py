"""Output of diagnostics: text with the source lines and carets for people, JSON for programs.

Tests and users rely on the text form; see `seoro check`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.frozen import Value
from seoro.lang.source import SourceFile

TAB_WIDTH = 4
MAX_WIDTH = 200  # shown characters of a line
Paint: TypeAlias = Callable[[str, str], str]  # wraps a text in an ANSI code
_RESET = "\x1b[0m"
_BOLD = "\x1b[1m"
_BLUE = "\x1b[34;1m"
_COLOURS = {Severity.ERROR: "\x1b[31;1m", Severity.WARNING: "\x1b[33;1m"}


def to_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """Convert a diagnostic to one flat JSON object; lines and columns count from 1."""
    span = diagnostic.primary.span
    end_line, end_column = span.file.position(span.end)
    return {
        "file": span.file.name,
        "line": span.line,
        "column": span.column,
        "end_line": end_line,
        "end_column": end_column,
        "severity": diagnostic.severity.value,
        "code": diagnostic.code,
        "message": diagnostic.message,
        "help": diagnostic.help,
    }


def render_text(diagnostic: Diagnostic, colour: bool = False) -> str:
    """Format a diagnostic with its source lines.

    Args:
        diagnostic: The diagnostic.
        colour: Whether to use ANSI colours.
    """
    paint = partial(_painted, on=colour)
    labels = (diagnostic.primary, *diagnostic.secondary)
    files: list[SourceFile] = []
    for label in labels:
        if label.span.file.text and label.span.file not in files:  # unreadable files have no text
            files.append(label.span.file)
    width = len(str(max(label.span.line for label in labels)))
    kind = paint(_COLOURS[diagnostic.severity], f"{diagnostic.severity.value}[{diagnostic.code}]")
    lines = [kind + paint(_BOLD, f": {diagnostic.message}")]
    for number, file in enumerate(files):
        here = [label for label in labels if label.span.file is file]
        arrow = "-->" if number == 0 else ":::"
        lines.append(f"{' ' * width}{paint(_BLUE, arrow)} {here[0].span}")
        lines += _excerpt(here, diagnostic, width, paint)
    if diagnostic.help:
        lines.append(f"{' ' * width} {paint(_BLUE, '=')} {paint(_BOLD, 'help')}: {diagnostic.help}")
    return "\n".join(lines)


def _painted(tone: str, text: str, *, on: bool) -> str:
    """Wrap text in an ANSI code, if enabled."""
    return f"{tone}{text}{_RESET}" if on and text else text


class _Mark(Value):
    """A label within one line: columns from 0 in the shown line."""

    start: int
    end: int
    text: str
    sign: str
    tone: str


def _excerpt(labels: Sequence[Label], diagnostic: Diagnostic, width: int, paint: Paint) -> list[str]:
    """Return the lines of one file that labels refer to, with marks below them."""
    gutter = " " * width + " " + paint(_BLUE, "|")
    shown = [gutter]
    last = None
    for number in sorted({label.span.line for label in labels}):
        if last is not None and number > last + 1:
            shown.append(paint(_BLUE, "..."))
        last = number
        here = [label for label in labels if label.span.line == number]
        line, shift = _window(here)
        shown.append(f"{paint(_BLUE, f'{number:>{width}} |')} {_expand(line)}".rstrip())
        marks = [_place(label, line, shift, diagnostic) for label in here]
        shown += [f"{gutter} {row}" for row in _rows(marks, paint)]
    return shown


def _window(labels: Sequence[Label]) -> tuple[str, int]:
    """Return the shown part of the line in which labels start, and its shift; long lines are cut."""
    span = labels[0].span
    line = span.file.line(span.line)
    if len(line) <= MAX_WIDTH:
        return line, 0
    start = max(0, min(label.span.column for label in labels) - MAX_WIDTH // 4)
    before = "..." if start else ""
    after = "..." if start + MAX_WIDTH < len(line) else ""
    return f"{before}{line[start : start + MAX_WIDTH]}{after}", len(before) - start


def _expand(text: str) -> str:
    """Replace tabs by `TAB_WIDTH` blanks, and other control characters by one."""
    return "".join(
        " " * TAB_WIDTH if char == "\t" else char if char.isprintable() or char == " " else " " for char in text
    )


def _place(label: Label, line: str, shift: int, diagnostic: Diagnostic) -> _Mark:
    """Return the mark of a label; a span of several lines is marked to the end of the first one."""
    start = min(label.span.column - 1 + shift, len(line))
    end = min(start + label.span.end - label.span.start, len(line.rstrip()))
    shown_start = len(_expand(line[:start]))
    shown_end = max(len(_expand(line[:end])), shown_start + 1)
    sign, tone = ("^", _COLOURS[diagnostic.severity]) if label is diagnostic.primary else ("-", _BLUE)
    return _Mark(shown_start, shown_end, label.text, sign, tone)


def _rows(marks: Sequence[_Mark], paint: Paint) -> list[str]:
    """Return the row of carets with the text of the last mark, then the other texts below their marks."""
    ordered = sorted(marks, key=lambda mark: mark.start)
    row, column = "", 0
    for mark in ordered:
        if mark.end <= column:
            continue
        start = max(mark.start, column)
        row += " " * (start - column) + paint(mark.tone, mark.sign * (mark.end - start))
        column = mark.end
    last = ordered[-1]
    if last.text:
        row += f" {last.text}"
    return [row, *(" " * mark.start + mark.text for mark in reversed(ordered[:-1]) if mark.text)]
