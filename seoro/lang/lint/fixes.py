"""Safe fixes of warnings: sections of the text to delete. Comments of other kinds and the layout stay."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from seoro.lang.diagnostic import Diagnostic
from seoro.lang.diagnostics import suspicious as messages
from seoro.lang.source import Span

_BLANK: Final = " \t"
_COLON: Final = re.compile(r"[ \t]*:[ \t]*")
_LINE_END: Final = re.compile(r"\r\n?|\n|\Z")
UNNECESSARY: Final = frozenset(
    {
        messages.UNUSED_PARAMETER,
        messages.UNUSED_EVENT,
        messages.UNUSED_IMPORT,
        messages.UNREACHABLE,
        messages.UNUSED_SUPPRESSION,
        messages.UNUSED_LABEL,
    }
)  # codes of text without effect


def deletion(found: Diagnostic) -> Span | None:
    """Return the section whose deletion fixes a warning; None without a safe fix.

    An import that has its line to itself is deleted with the line. A comment is deleted with the blanks before it.
    """
    span = found.primary.span
    if found.code == messages.UNUSED_LABEL:
        colon = _COLON.match(span.file.text, span.end)
        return None if colon is None else Span(span.file, span.start, colon.end())
    text, start, end = span.file.text, span.start, span.end
    while start > 0 and text[start - 1] in _BLANK:
        start -= 1
    while end < len(text) and text[end] in _BLANK:
        end += 1
    line_end = _LINE_END.match(text, end)
    begins_line = start == 0 or text[start - 1] in "\r\n"
    if line_end is None:
        return None
    if found.code == messages.UNUSED_SUPPRESSION and text[span.start] == "#":
        return Span(span.file, start, line_end.end() if begins_line else end)
    if found.code == messages.UNUSED_IMPORT and begins_line:
        return Span(span.file, start, line_end.end())
    return None


def without(text: str, sections: Iterable[Span]) -> str:
    """Return a text without some of its sections, which do not overlap."""
    for span in sorted(sections, key=lambda section: section.start, reverse=True):
        text = text[: span.start] + text[span.end :]
    return text
