"""Identifiers in texts, without comments and strings; cheaper than a walk over the tree."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from typing import Final

from seoro.lang.frozen import Value
from seoro.lang.source import SourceFile

SKIPPED: Final = (
    r"\#[^\r\n]*"
    r'|"""(?:\\.|[^\\])*?"""'
    r"|'''(?:\\.|[^\\])*?'''"
    r'|"(?:\\.|[^"\\\r\n])*"'
    r"|'(?:\\.|[^'\\\r\n])*'"
)
_WORD: Final = re.compile(rf"{SKIPPED}|([A-Za-z_]\w*)", re.DOTALL)


class Words(Value):
    """Identifiers and keywords of files.

    Args:
        counts: Their numbers.
        emitted: Words directly behind `emit`: names of events, and of their namespaces.
    """

    counts: Counter[str]
    emitted: frozenset[str]


def read_words(files: Iterable[SourceFile]) -> Words:
    """Read the identifiers and keywords of files."""
    counts: Counter[str] = Counter()
    emitted: set[str] = set()
    for file in files:
        words = [word for word in _WORD.findall(file.text) if word]
        counts.update(words)
        for number, word in enumerate(words):
            if word == "emit":
                emitted.update(words[number + 1 : number + 3])
    return Words(counts, frozenset(emitted))
