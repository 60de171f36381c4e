"""Pairs of runs of two campaigns with the same values, seed and repeat; files and versions may differ."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TypeAlias

from seoro.campaign.runs import End, Row
from seoro.campaign.store.index import RowIndex
from seoro.lang.frozen import Value

DURATION = "duration"
Key: TypeAlias = tuple[str, int, int]
"""Variant (values as JSON), seed and repeat."""


class Side(Value):
    """A run of one of the campaigns.

    Args:
        run: Its number there.
        end: Its end.
        trace_sha: Hash of its trace.
        numbers: Its duration [s] and its measurements that are numbers, by column.
    """

    run: int
    end: End
    trace_sha: str
    numbers: Mapping[str, float]

    @property
    def has_verdict(self) -> bool:
        """Whether it passed or failed."""
        return self.end in (End.PASSED, End.FAILED)


class Pair(Value):
    """Runs with the same values, seed and repeat.

    Args:
        variant: Their values.
        seed: Their seed.
        before: Run of the first campaign.
        after: Run of the second one.
        reason: Reason of the verdict of the second one.
    """

    variant: str
    seed: int
    before: Side
    after: Side
    reason: str

    @property
    def values(self) -> dict[str, object]:
        """Values of the parameters that vary."""
        values: dict[str, object] = json.loads(self.variant)
        return values


class Joined(Value):
    """Two campaigns, joined.

    Args:
        pairs: Pairs, in the order of the second campaign.
        before: Number of runs by end, of all runs of the first campaign.
        after: The same of the second one.
    """

    pairs: tuple[Pair, ...]
    before: Mapping[End, int]
    after: Mapping[End, int]


def join(before: Path, after: Path) -> Joined:
    """Join two campaigns.

    Args:
        before, after: Their folders. Of several runs with the same values, seed and repeat, the first counts.

    Raises:
        UsageError: A row is invalid.
    """
    first, of_first = _sides(RowIndex(before))
    ends: dict[End, int] = {}
    pairs = []
    for row in RowIndex(after):
        ends[row.status] = ends.get(row.status, 0) + 1
        found = first.pop(_key(row), None)
        if found is not None:
            variant, seed, _ = _key(row)
            pairs.append(Pair(variant, seed, found, _side(row), row.reason))
    return Joined(tuple(pairs), of_first, ends)


def _sides(rows: Iterable[Row]) -> tuple[dict[Key, Side], dict[End, int]]:
    sides: dict[Key, Side] = {}
    ends: dict[End, int] = {}
    for row in rows:
        ends[row.status] = ends.get(row.status, 0) + 1
        sides.setdefault(_key(row), _side(row))
    return sides, ends


def _key(row: Row) -> Key:
    return json.dumps(row.values, sort_keys=True), row.seed, row.repeat


def _side(row: Row) -> Side:
    return Side(row.run, row.status, row.trace_sha, dict(_numbers(row)))


def _numbers(row: Row) -> Iterator[tuple[str, float]]:
    for name, value in ((DURATION, row.duration), ("margin", row.margin), *row.measured.items()):
        if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
            yield name, float(value)
