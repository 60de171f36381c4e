"""Suppression of warnings by comments: `# noqa`, or `# noqa: E0701, E0702`, at the end of the line."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Final

from seoro.lang.diagnostic import Diagnostic, Severity
from seoro.lang.diagnostics import suspicious as messages
from seoro.lang.explain import codes, near_codes
from seoro.lang.frozen import Value
from seoro.lang.lint.words import SKIPPED
from seoro.lang.source import SourceFile, Span

_TOKEN: Final = re.compile(SKIPPED, re.DOTALL)
_NOQA: Final = re.compile(r"#\s*noqa\b(?::\s*(?P<codes>[A-Za-z]\w*(?:[\s,]+[A-Za-z]\d\w*)*))?", re.IGNORECASE)
_CODE: Final = re.compile(r"\w+")
LINTS: Final = "E07"  # codes that every check reports


class Suppression(Value):
    """A `noqa` comment.

    Args:
        span: The comment.
        codes: Its codes in upper case, with their places; empty for all.
    """

    span: Span
    codes: tuple[tuple[str, Span], ...]

    def covers(self, found: Diagnostic) -> bool:
        """Return whether it suppresses a diagnostic: a warning that begins or ends in its line."""
        span = found.primary.span
        if found.severity is not Severity.WARNING or span.file is not self.span.file:
            return False
        lines = (span.line, span.file.position(span.end)[0])
        return self.span.line in lines and (not self.codes or found.code in dict(self.codes))


def suppressions(file: SourceFile) -> list[Suppression]:
    """Return the `noqa` comments of a file, in order."""
    if "noqa" not in file.text.lower():
        return []
    found = []
    for token in _TOKEN.finditer(file.text):
        comment = _NOQA.search(token[0]) if token[0].startswith("#") else None
        if comment is not None:
            start = token.start()
            inner = _CODE.finditer(token[0], *comment.span("codes")) if comment["codes"] else ()
            given = tuple(
                (each[0].upper(), Span(file, start + each.start(), start + each.end())) for each in inner
            )
            found.append(Suppression(Span(file, start + comment.start(), start + comment.end()), given))
    return found


def apply_suppressions(
    found: Iterable[Diagnostic], files: Iterable[SourceFile], own: SourceFile
) -> list[Diagnostic]:
    """Return the diagnostics that no comment suppresses, with warnings about comments without effect.

    Codes that only `--strict` or an import of Python reports are never called unused.

    Args:
        found: The diagnostics.
        files: The files whose comments hold.
        own: The file whose comments without effect are reported.
    """
    comments = [comment for file in files for comment in suppressions(file)]
    kept: list[Diagnostic] = []
    used: set[tuple[int, str]] = set()  # places of comments with codes
    for diagnostic in found:
        covering = [comment for comment in comments if comment.covers(diagnostic)]
        used.update((comment.span.start, code) for comment in covering for code in (diagnostic.code, ""))
        if not covering:
            kept.append(diagnostic)
    for comment in comments:
        if comment.span.file is own:
            kept += _without_effect(comment, used)
    return kept


def _without_effect(comment: Suppression, used: set[tuple[int, str]]) -> Iterator[Diagnostic]:
    if not comment.codes and (comment.span.start, "") not in used:
        yield messages.unused_suppression(_removable(comment), "")
    for code, span in comment.codes:
        if code not in codes():
            yield messages.unknown_suppression(span, code, near_codes(code) or "`seoro explain` lists all codes")
        elif code.startswith(LINTS) and (comment.span.start, code) not in used:
            yield messages.unused_suppression(_removable(comment) if len(comment.codes) == 1 else span, code)


def _removable(comment: Suppression) -> Span:
    """Return the whole comment, or a part of it if more text follows, so that it is not deleted."""
    span = comment.span
    end_column = span.column - 1 + span.end - span.start
    if not span.file.line(span.line)[end_column:].strip():
        return span
    return comment.codes[0][1] if comment.codes else Span(span.file, span.start + 1, span.end)
