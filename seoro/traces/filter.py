"""Filter for the records of a trace."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from seoro.traces.reader import Paths, Record


@dataclass(frozen=True)
class Filter:
    """Conditions that a record must satisfy, all of them.

    Args:
        kinds: Glob patterns for the kind, of which one must match; empty for any kind.
        paths: Glob patterns for its subject: path of a behavior or variable, name of an event, item of coverage.
        start: Earliest time [s], clock of the run.
        end: Latest time [s].
        text: Regular expression that must match a value.
    """

    kinds: Sequence[str] = ()
    paths: Sequence[str] = ()
    start: float = -math.inf
    end: float = math.inf
    text: re.Pattern[str] | None = None


def select(records: Iterable[Record], filters: Filter) -> Iterator[Record]:
    """Yield the records that match the filters, in order."""
    paths = Paths()
    for record in records:
        path = paths.of(record)
        if not filters.start <= record["t"] <= filters.end:
            continue
        if filters.kinds and not any(fnmatchcase(record["kind"], kind) for kind in filters.kinds):
            continue
        # `[0]` in a path is an index, not a set of characters.
        if filters.paths and not any(fnmatchcase(path, pattern.replace("[", "[[]")) for pattern in filters.paths):
            continue
        if filters.text is not None and not any(filters.text.search(text) for text in (path, *_texts(record))):
            continue
        yield record


def _texts(record: Record) -> Iterator[str]:
    for name, value in record.items():
        if name not in ("seq", "t", "wall", "kind"):
            yield str(value)
