"""Choosing the records of a trace that someone wants to see."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from seoro.traces.read import Paths, Record


@dataclass(frozen=True)
class Choice:
    """Which records are wanted; all of it has to be true of a record.

    Args:
        kinds: Patterns (`*` for anything) for the kind, one of which has to fit; any if there are none.
        paths: Patterns likewise for what it is about: the path of a behavior or a variable, the name of an event,
            an item of coverage.
        start: From what time on [s of the run's clock].
        end: Up to what time [s].
        text: Has to be found in one of its values.
    """

    kinds: Sequence[str] = ()
    paths: Sequence[str] = ()
    start: float = -math.inf
    end: float = math.inf
    text: re.Pattern[str] | None = None

    @property
    def is_all(self) -> bool:
        """Whether it leaves nothing out."""
        return self == Choice()


def choose(records: Iterable[Record], choice: Choice) -> Iterator[Record]:
    """The records that are wanted, in their order."""
    paths = Paths()
    for record in records:
        path = paths.of(record)
        if not choice.start <= record["t"] <= choice.end:
            continue
        if choice.kinds and not any(fnmatchcase(record["kind"], kind) for kind in choice.kinds):
            continue
        # `[0]` in a path is an index, not a set of characters.
        if choice.paths and not any(fnmatchcase(path, pattern.replace("[", "[[]")) for pattern in choice.paths):
            continue
        if choice.text is not None and not any(choice.text.search(text) for text in (path, *_texts(record))):
            continue
        yield record


def _texts(record: Record) -> Iterator[str]:
    for name, value in record.items():
        if name not in ("seq", "t", "wall", "kind"):
            yield str(value)
