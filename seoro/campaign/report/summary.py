"""Summary of the rows of a campaign: one pass, in constant memory."""

from __future__ import annotations

from bisect import insort
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from itertools import islice
from typing import Any, Final, TypeAlias

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.report.columns import MOST_COLUMNS, Column, count_columns, values_of
from seoro.campaign.report.common_values import CommonValues
from seoro.campaign.report.reservoir import Reservoir
from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import End, Row
from seoro.campaign.store.batches import Batch
from seoro.deferred import dataclass

MOST_ROWS: Final = 500  # in the table of runs
MOST_GROUPS: Final = 200  # of failures; more are counted as one
SAMPLE: Final = 20_000  # runs for pairs of parameters
MORE: Final = ("other reasons", "")

Rank: TypeAlias = tuple[bool, float, int]


@dataclass(eq=False)
class FailureGroup:
    """Failures with the same reason at the same place.

    Args:
        example: The first of them, by number.
        count: Their number.
        is_same: Whether their reasons are the same, with all numbers.
        values: Values of each parameter.
    """

    example: Row
    count: int = 0
    is_same: bool = True
    values: dict[str, CommonValues] = field(default_factory=dict)

    def add(self, reasons: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> None:
        """Count failures.

        Args:
            reasons: Their reasons.
            rows: Values of their parameters.
        """
        self.is_same = self.is_same and all(reason == self.example.reason for reason in reasons)
        if not self.count:
            self.values = {path: CommonValues() for path in islice(rows[0], MOST_COLUMNS)}
        self.count += len(rows)
        for path, values in self.values.items():
            values.add(values_of(rows, path))


@dataclass(eq=False)
class Summary(Tally):
    """Content of a report, with the counts of runs.

    Args:
        failures: Groups of runs that did not pass, by reason and place.
        parameters: Counts by parameter.
        measurements: Counts by measurement.
        sample: Random sample of the runs with a verdict: their parameters, and whether they failed.
        worst: Runs that did not pass, then those with the smallest margins, in this order.
        coverage: Coverage over all runs.
        hosts: Runs by machine.
        cpu: Processor time of workers and simulators [s].
        first: Time of the first start (UTC); empty without a run.
        last: Time of the last start.
    """

    failures: dict[tuple[str, str], FailureGroup] = field(default_factory=dict)
    parameters: dict[str, Column] = field(default_factory=dict)
    measurements: dict[str, Column] = field(default_factory=dict)
    sample: Reservoir[tuple[Mapping[str, Any], bool]] = field(default_factory=lambda: Reservoir(SAMPLE, 0))
    worst: list[tuple[Rank, Row]] = field(default_factory=list)
    coverage: MergedCoverage = field(default_factory=MergedCoverage)
    hosts: Counter[str] = field(default_factory=Counter)
    cpu: float = 0.0
    first: str = ""
    last: str = ""

    @property
    def decided(self) -> int:
        """Number of runs that passed or failed."""
        return self.ends[End.PASSED] + self.ends[End.FAILED]


def summarize(batches: Iterable[Batch], seed: int, coverage: MergedCoverage | None = None) -> Summary:
    """Summarize the rows of a campaign.

    Args:
        batches: A row for each run, in any order.
        seed: Seed of the random sample for pairs of parameters.
        coverage: Coverage without runs, for items that are defined; None if they are unknown.
    """
    found = Summary(coverage=coverage or MergedCoverage(), sample=Reservoir(SAMPLE, seed))
    for batch in batches:
        add_batch(found, batch)
    return found


def add_batch(found: Summary, batch: Batch) -> None:
    """Add rows to a summary.

    Args:
        found: The summary.
        batch: A row for each of some runs, which it does not have yet.

    Raises:
        UsageError: A row is invalid.
    """
    found.count_batch(batch)
    _count(found, _made(batch))


def _made(batch: Batch) -> Batch:
    """Leave out runs that constraints exclude, which are only counted."""
    excluded = batch.ends.get(End.IMPOSSIBLE, ())
    if not excluded:
        return batch
    without = set(excluded)
    return batch.select([position for position in range(len(batch)) if position not in without])


def _count(found: Summary, batch: Batch) -> None:
    found.cpu += sum(batch.column("cpu")) + sum(batch.column("sim_cpu"))
    _count_hosts(found, batch)
    _group(found.failures, batch)
    _rank(found.worst, batch)
    passed, failed = batch.ends.get(End.PASSED, ()), batch.ends.get(End.FAILED, ())
    found.coverage.add_batch(batch)
    values, measured = batch.column("values"), batch.column("measured")
    for positions, has_failed in ((passed, False), (failed, True)):
        chosen = [values[position] for position in positions]
        found.sample.extend([(each, has_failed) for each in chosen])
        count_columns(found.parameters, chosen, has_failed)
        count_columns(found.measurements, [measured[position] for position in positions], has_failed)


def _count_hosts(found: Summary, batch: Batch) -> None:
    for host, count in Counter(batch.column("host")).items():
        if host in found.hosts or len(found.hosts) < MOST_GROUPS:
            found.hosts[host] += count
    started = [each for each in batch.column("started") if each]
    if started:
        found.first = min(found.first or started[0], *started)
        found.last = max(found.last, *started)


def _group(groups: dict[tuple[str, str], FailureGroup], batch: Batch) -> None:
    runs, keys, places = batch.column("run"), batch.column("reason_key"), batch.column("where")
    reasons, values = batch.column("reason"), batch.column("values")
    found: dict[tuple[str, str], list[int]] = {}
    for end, positions in batch.ends.items():
        for position in positions if end is not End.PASSED else ():
            key = (keys[position] or end.value, places[position])
            if key not in groups and len(groups) >= MOST_GROUPS:
                key = MORE
            group = groups.get(key)
            if group is None:
                group = groups[key] = FailureGroup(batch.row(position))
            elif runs[position] < group.example.run:
                group.example = batch.row(position)
            found.setdefault(key, []).append(position)
    for key, chosen in found.items():
        groups[key].add([reasons[each] for each in chosen], [values[each] for each in chosen])


def _rank(worst: list[tuple[Rank, Row]], batch: Batch) -> None:
    runs, margins = batch.column("run"), batch.column("margin")
    for end, positions in sorted(batch.ends.items(), key=lambda each: each[0] is End.PASSED):
        has_passed = end is End.PASSED
        for position in positions:
            if has_passed and margins[position] is None:
                continue
            rank = (has_passed, margins[position] or 0.0, runs[position])
            if len(worst) < MOST_ROWS or rank < worst[-1][0]:
                insort(worst, (rank, batch.row(position)), key=lambda item: item[0])
                del worst[MOST_ROWS:]
            elif has_passed and not worst[-1][0][0]:
                break  # there are enough that did not pass
