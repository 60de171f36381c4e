"""Comparison of two recorded runs: different settings, and the first difference of their records."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import chain
from typing import Any

from seoro.traces.difference import Difference, first_difference
from seoro.traces.reader import Record


class NoBeginning(Exception):
    """The records of a run do not begin with its start.

    Args:
        index: 0 for the first run, 1 for the second.
    """

    def __init__(self, index: int) -> None:
        super().__init__("the trace has no beginning")
        self.index = index


@dataclass(frozen=True)
class Comparison:
    """Differences of two runs.

    Args:
        settings: Name and both values of each setting that differs.
        difference: First difference of the records; None if they are equal.
    """

    settings: tuple[tuple[str, str, str], ...]
    difference: Difference | None

    @property
    def is_equal(self) -> bool:
        """Whether the runs are equal."""
        return self.difference is None and not self.settings

    @property
    def data(self) -> dict[str, Any]:
        """JSON data of the comparison."""
        return {
            "settings": [list(each) for each in self.settings],
            "difference": None if self.difference is None else asdict(self.difference),
        }


def compare_runs(first: Iterable[Record], second: Iterable[Record]) -> Comparison:
    """Compare two runs, in memory that does not grow with them.

    Args:
        first: Records of a run.
        second: Records of another run.

    Raises:
        NoBeginning: The records of a run do not begin with its start.
    """
    (start, ours), (other, theirs) = _begun(first, 0), _begun(second, 1)
    return Comparison(tuple(_settings(start, other)), first_difference(ours, theirs))


def _begun(records: Iterable[Record], index: int) -> tuple[Record, Iterator[Record]]:
    found = iter(records)
    start = next(found, None)
    if start is None or start["kind"] != "run.start":
        raise NoBeginning(index)
    return start, chain([start], found)


def _settings(first: Record, second: Record) -> Iterator[tuple[str, str, str]]:
    """Yield the settings that differ: name, and both values."""
    for name in ("scenario", "seed", "clock", "version"):
        if first.get(name) != second.get(name):
            yield name, str(first.get(name)), str(second.get(name))
    ours, theirs = (found.get("parameters") or {} for found in (first, second))
    for name in sorted({**ours, **theirs}):
        if ours.get(name) != theirs.get(name):
            yield f"parameter {name}", json.dumps(ours.get(name)), json.dumps(theirs.get(name))
    hashes = [
        {source.get("name"): source.get("sha256") for source in found.get("sources") or ()}
        for found in (first, second)
    ]
    for name in sorted(set(hashes[0]) & set(hashes[1])):
        if hashes[0][name] != hashes[1][name]:
            yield f"text of {name}", str(hashes[0][name])[:8], str(hashes[1][name])[:8]
