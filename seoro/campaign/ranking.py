"""Ranking of runs: the fewest runs that keep all buckets of coverage.

The choice is greedy: the next run is the one with most new buckets. That is at most `ln n + 1` times the least
number for n buckets (Chvatal, "A greedy heuristic for the set-covering problem", 1979). Gains only fall, so most
are not computed again (Minoux, "Accelerated greedy algorithms", 1978). Sets are bits of integers.
"""

from __future__ import annotations

import heapq
from collections.abc import Container, Iterator, Mapping, Sequence
from typing import NamedTuple

from seoro.campaign.runs import End, Row
from seoro.lang.frozen import Value
from seoro.lang.plan import CoverageKind


class Ranked(Value):
    """Run of a ranking.

    Args:
        run: Its number.
        new: Number of buckets that no run before it has.
        total: Number of buckets of it and all runs before it.
        failure: Reason of its failure; empty if it passed.
    """

    run: int
    new: int
    total: int
    failure: str = ""


class _Candidate(NamedTuple):
    """Run with a set of buckets; less is better."""

    has_failed: bool
    run: int
    failure: str


class Ranking:
    """Sets of buckets of runs, in memory that does not grow with the number of equal sets.

    Args:
        failures: Whether each kind of failure must be kept, too; these come first.
    """

    def __init__(self, *, failures: bool = False) -> None:
        self._failures = failures
        self._bits: dict[tuple[str, str], int] = {}  # by item and bucket
        self._best: dict[int, _Candidate] = {}  # by set of buckets
        self._kinds: dict[tuple[str, str], tuple[_Candidate, int]] = {}  # first run of each failure, and its set
        self.runs = 0

    @property
    def buckets(self) -> int:
        """Number of buckets of all runs."""
        return len(self._bits)

    def add(self, row: Row) -> None:
        """Add a run; runs without a verdict are left out."""
        if row.status not in (End.PASSED, End.FAILED):
            return
        self.runs += 1
        found = self._set_of(row)
        has_failed = row.status is End.FAILED
        candidate = _Candidate(has_failed, row.run, (row.reason or "failed") if has_failed else "")
        self._best[found] = min(self._best.get(found, candidate), candidate)
        if self._failures and has_failed:
            kind = (row.reason_key, row.where)
            self._kinds[kind] = min(self._kinds.get(kind, (candidate, found)), (candidate, found))

    def _set_of(self, row: Row) -> int:
        found = 0
        for item in row.coverage:
            if item["kind"] != CoverageKind.COVER.value or item["total"] is None:  # has any number of buckets
                continue
            for bucket in item["buckets"]:
                found |= 1 << self._bits.setdefault((item["item"], bucket), len(self._bits))
        return found

    def chosen(self) -> Sequence[Ranked]:
        """Return the runs to keep, the most useful first."""
        kept = sorted(self._kinds.values())
        failures = {each.run: each.failure for each in (*self._best.values(), *(each for each, _ in kept))}
        sets = {each.run: found for each, found in kept}
        covered = 0
        for found in sets.values():
            covered |= found
        others = sorted((candidate, found) for found, candidate in self._best.items())
        wanted = tuple(sets)
        sets |= greedy({each.run: found for each, found in others}, covered)
        return tuple(_ranked(_needed(sets, wanted), failures))


def greedy(sets: Mapping[int, int], covered: int = 0) -> Iterator[tuple[int, int]]:
    """Yield runs with their sets until nothing is missing; of runs with equal gains, the first of the mapping.

    Args:
        sets: Sets of buckets as bits, by number of the run.
        covered: Buckets that need no run.
    """
    heap = [(-(found & ~covered).bit_count(), order, run) for order, (run, found) in enumerate(sets.items())]
    heapq.heapify(heap)
    while heap:
        _, order, run = heap[0]
        gain = (sets[run] & ~covered).bit_count()
        if gain == 0:
            heapq.heappop(heap)
            continue
        heapq.heapreplace(heap, (-gain, order, run))
        if heap[0][2] == run:
            heapq.heappop(heap)
            covered |= sets[run]
            yield run, sets[run]


def _needed(sets: Mapping[int, int], wanted: Container[int]) -> dict[int, int]:
    """Leave out runs whose buckets others have, the last first; wanted ones stay."""
    kept, before = dict(sets), {}
    union = 0
    for run, found in sets.items():
        before[run] = union
        union |= found
    after = 0  # buckets of kept runs that come later
    for run in reversed([*sets]):
        if run not in wanted and not kept[run] & ~(before[run] | after):
            del kept[run]
        else:
            after |= kept[run]
    return kept


def _ranked(sets: Mapping[int, int], failures: Mapping[int, str]) -> Iterator[Ranked]:
    covered = 0
    for run, found in sets.items():
        new = (found & ~covered).bit_count()
        covered |= found
        yield Ranked(run, new, covered.bit_count(), failures[run])
