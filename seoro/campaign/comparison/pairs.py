"""Pairs of runs of two campaigns with the same values, seed and repeat; files and versions may differ.

Columns of numbers are kept, and rows are read again when a pair is looked at. So a million pairs fit into memory.
"""

from __future__ import annotations

import json
import math
from array import array
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from hashlib import blake2b
from pathlib import Path
from typing import Any, Final, overload

from seoro.campaign.report.columns import Column, count_columns
from seoro.campaign.runs import End, Row
from seoro.campaign.store.batches import Batch
from seoro.campaign.store.index import RowIndex
from seoro.lang.frozen import Value

DURATION = "duration"
_ENDS: Final = tuple(End)
_NUMBERS: Final = {end.value: number for number, end in enumerate(_ENDS)}
_BYTES: Final = 8  # of a hash; among a million runs, two have the same with a probability of 3e-8
_NAN: Final = array("d", [math.nan])


class Side(Value):
    """A run of one of the campaigns.

    Args:
        run: Its number there.
        end: Its end.
    """

    run: int
    end: End

    @property
    def has_verdict(self) -> bool:
        """Whether it passed or failed."""
        return self.end in (End.PASSED, End.FAILED)


class Pair(Value):
    """Runs with the same values, seed and repeat.

    Args:
        values: Values of the parameters that vary.
        seed: Their seed.
        before: Run of the first campaign.
        after: Run of the second one.
        reason: Reason of the verdict of the second one.
    """

    values: Mapping[str, object]
    seed: int
    before: Side
    after: Side
    reason: str


class _Columns:
    """Columns of the runs of a campaign.

    Attributes:
        runs: Their numbers.
        ends: Their ends, as positions in `_ENDS`.
        variants: Hashes of their values.
        seeds: Their seeds.
        traces: Hashes of their traces; 0 without one.
        numbers: Durations [s], margins and measurements that are numbers, by column; NaN if missing.
    """

    def __init__(self) -> None:
        self.runs, self.variants, self.seeds, self.traces = array("q"), array("q"), array("q"), array("q")
        self.ends = bytearray()
        self.numbers: dict[str, array[float]] = {}

    def add(self, batch: Batch, position: int, variant: int) -> None:
        """Add a run of a batch."""
        before = len(self.runs)
        self.runs.append(batch.column("run")[position])
        self.variants.append(variant)
        self.seeds.append(batch.column("seed")[position])
        trace = batch.column("trace_sha")[position]
        self.traces.append(_hash(trace) if trace else 0)
        self.ends.append(_NUMBERS[batch.column("status")[position]])
        own = ((DURATION, batch.column(DURATION)[position]), ("margin", batch.column("margin")[position]))
        for name, value in (*own, *batch.column("measured")[position].items()):
            if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
                column = self.numbers.setdefault(name, array("d"))
                column.extend(_NAN * (before - len(column)))
                column.append(float(value))

    def finish(self) -> None:
        """Fill the ends of columns, after the last run."""
        for column in self.numbers.values():
            column.extend(_NAN * (len(self.runs) - len(column)))


class Joined:
    """Two campaigns, joined by `join`.

    Attributes:
        before: Number of runs by end, of all runs of the first campaign.
        after: The same of the second one.
        numbers: Numbers by column: of all runs of the first campaign, and of the second runs of pairs.
        places: Positions of the first runs of pairs in their columns.
        variants: Hashes of the values of pairs.
        seeds: Seeds of pairs.
        parameters: Counts by parameter of the second runs of pairs whose first runs passed.
    """

    def __init__(
        self, rows: tuple[RowIndex, RowIndex], first: _Columns, second: _Columns, places: array[int]
    ) -> None:
        self._rows = rows
        self._first = first
        self._second = second
        self.places = places
        self.variants, self.seeds = second.variants, second.seeds
        self.numbers = first.numbers, second.numbers
        self.before: Mapping[End, int] = {}
        self.after: Mapping[End, int] = {}
        self.parameters: dict[str, Column] = {}

    @property
    def pairs(self) -> Pairs:
        """All pairs, in the order of the second campaign."""
        return Pairs(self, range(len(self.places)))

    def ends(self, position: int) -> tuple[End, End]:
        """Return the ends of the runs of a pair."""
        return _ENDS[self._first.ends[self.places[position]]], _ENDS[self._second.ends[position]]

    def select(self, wanted: Callable[[End, End], bool]) -> Pairs:
        """Return the pairs with some ends."""
        known = {(first, second): wanted(first, second) for first in _ENDS for second in _ENDS}
        found = (position for position in range(len(self.places)) if known[self.ends(position)])
        return Pairs(self, array("q", found))

    @property
    def equal(self) -> int:
        """Number of pairs with equal traces."""
        first, second = self._first.traces, self._second.traces
        return sum(bool(trace) and first[place] == trace for place, trace in zip(self.places, second, strict=True))

    def pair(self, position: int) -> Pair:
        """Return a pair; its runs are read."""
        before, after = self.ends(position)
        row = self.row(position)
        first = self._first.runs[self.places[position]]
        return Pair(row.values, row.seed, Side(first, before), Side(row.run, after), row.reason)

    def row(self, position: int) -> Row:
        """Return the row of the second run of a pair."""
        row = self._rows[1].find(self._second.runs[position])
        assert row is not None, "it was there"
        return row


class Pairs(Sequence[Pair]):
    """Some pairs, which are read when they are looked at.

    Args:
        joined: Both campaigns.
        positions: Positions of the pairs.
    """

    def __init__(self, joined: Joined, positions: Sequence[int]) -> None:
        self._joined = joined
        self.positions = positions

    def __len__(self) -> int:
        return len(self.positions)

    @overload
    def __getitem__(self, index: int) -> Pair: ...

    @overload
    def __getitem__(self, index: slice) -> Pairs: ...

    def __getitem__(self, index: int | slice) -> Pair | Pairs:
        if isinstance(index, slice):
            return Pairs(self._joined, self.positions[index])
        return self._joined.pair(self.positions[index])

    def __iter__(self) -> Iterator[Pair]:
        return map(self._joined.pair, self.positions)


def join(before: Path, after: Path) -> Joined:
    """Join two campaigns.

    Args:
        before, after: Their folders. Of several runs with the same values, seed and repeat, the first counts.

    Raises:
        UsageError: A row is invalid.
    """
    rows = RowIndex(before), RowIndex(after)
    first, second = _Columns(), _Columns()
    of_first, of_second = Counter[End](), Counter[End]()
    keys, places = array("q"), array("q")
    for batch in rows[0].batches():
        _count(batch, of_first)
        for position, (key, variant) in enumerate(_keys(batch)):
            keys.append(key)
            first.add(batch, position, variant)
    order = array("q", sorted(range(len(keys)), key=keys.__getitem__))  # of equal keys, the first run comes first
    is_taken = bytearray(len(keys))
    joined = Joined(rows, first, second, places)
    for batch in rows[1].batches():
        _count(batch, of_second)
        in_pairs = array("q")
        for position, (key, variant) in enumerate(_keys(batch)):
            at = bisect_left(order, key, key=keys.__getitem__)
            if at < len(order) and keys[order[at]] == key and not is_taken[order[at]]:
                is_taken[order[at]] = True
                places.append(order[at])
                second.add(batch, position, variant)
                in_pairs.append(position)
        _count_parameters(joined, batch, in_pairs)
    for each in (first, second):
        each.finish()
    joined.before, joined.after = of_first, of_second
    return joined


def _count_parameters(joined: Joined, batch: Batch, positions: Sequence[int]) -> None:
    """Count the second runs of the last pairs, if their first runs passed.

    Args:
        joined: Both campaigns.
        batch: Rows of the second one.
        positions: Those of pairs.
    """
    values = batch.column("values")
    chosen: dict[tuple[End, End], list[Mapping[str, Any]]] = {}
    for pair, position in enumerate(positions, start=len(joined.places) - len(positions)):
        chosen.setdefault(joined.ends(pair), []).append(values[position])
    for end, has_failed in ((End.PASSED, False), (End.FAILED, True)):
        count_columns(joined.parameters, chosen.get((End.PASSED, end), ()), has_failed)


def _count(batch: Batch, ends: Counter[End]) -> None:
    ends.update({end: len(positions) for end, positions in batch.ends.items()})


def _keys(batch: Batch) -> Iterator[tuple[int, int]]:
    """Yield the hash of values, seed and repeat of each run, and that of the values alone."""
    columns: tuple[Sequence[Any], ...] = tuple(map(batch.column, ("values", "seed", "repeat")))
    for values, seed, repeat in zip(*columns, strict=True):
        variant = json.dumps(values, sort_keys=True)
        yield _hash(f"{seed} {repeat} {variant}"), _hash(variant)


def _hash(text: str) -> int:
    return int.from_bytes(blake2b(text.encode("utf-8", "surrogatepass"), digest_size=_BYTES).digest(), signed=True)
