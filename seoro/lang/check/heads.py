"""The first words of statements: where messages about a whole statement point to."""

from __future__ import annotations

from seoro.lang.source import Span


def head(span: Span, word: str) -> Span:
    """The word with which a statement begins."""
    return Span(span.file, span.start, min(span.start + len(word), span.end))
