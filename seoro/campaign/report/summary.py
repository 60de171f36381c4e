"""Summary of the rows of a campaign: one pass, in constant memory."""

from __future__ import annotations

import random
from bisect import insort
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from itertools import chain, islice
from typing import Any, Final, TypeAlias

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.report.columns import Column
from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import End, Row
from seoro.lang.lazy_dataclass import lazy_dataclass

MOST_ROWS: Final = 500  # in the table of runs
MOST_GROUPS: Final = 200  # of failures; more are counted as one
MOST_COLUMNS: Final = 200  # of parameters, and of measurements
SAMPLE: Final = 20_000  # runs for pairs of parameters
BATCH: Final = 1000  # rows that are counted at once
MORE: Final = ("other reasons", "")

Rank: TypeAlias = tuple[bool, float, int]


@lazy_dataclass
class FailureGroup:
    """Failures with the same reason at the same place.

    Args:
        example: The first of them, by number.
        count: Their number.
    """

    example: Row
    count: int = 0


@lazy_dataclass
class Summary(Tally):
    """Content of a report, with the counts of runs.

    Args:
        failures: Groups of runs that did not pass, by reason and place.
        parameters: Counts by parameter.
        measurements: Counts by measurement.
        sample: Random runs with a verdict: their parameters, and whether they failed.
        worst: Runs that did not pass, then those with the smallest margins, in this order.
        coverage: Coverage over all runs.
        hosts: Runs by machine.
        decided: Number of runs that passed or failed.
        cpu: Processor time of workers and simulators [s].
        first: Time of the first start (UTC); empty without a run.
        last: Time of the last start.
    """

    failures: dict[tuple[str, str], FailureGroup] = field(default_factory=dict)
    parameters: dict[str, Column] = field(default_factory=dict)
    measurements: dict[str, Column] = field(default_factory=dict)
    sample: list[tuple[Mapping[str, Any], bool]] = field(default_factory=list)
    worst: list[tuple[Rank, Row]] = field(default_factory=list)
    coverage: MergedCoverage = field(default_factory=MergedCoverage)
    hosts: Counter[str] = field(default_factory=Counter)
    decided: int = 0
    cpu: float = 0.0
    first: str = ""
    last: str = ""


def summarize(rows: Iterable[Row], seed: int, coverage: MergedCoverage | None = None) -> Summary:
    """Summarize the rows of a campaign.

    Args:
        rows: A row for each run, in any order.
        seed: Seed of the random sample for pairs of parameters.
        coverage: Coverage without runs, for items that are defined; None if they are unknown.
    """
    found, draw = Summary(coverage=coverage or MergedCoverage()), random.Random(seed)  # noqa: S311 - a sample
    rows = iter(rows)
    while batch := list(islice(rows, BATCH)):
        decided = []
        for row in batch:
            found.count(row)
            if row.status is not End.IMPOSSIBLE:
                _count(found, row)
            if row.status is End.PASSED or row.status is End.FAILED:
                decided.append(row)
                found.coverage.add(row)
                _sample(found, row, draw)
        failures = [row.status is End.FAILED for row in decided]
        _count_columns(found.parameters, [row.values for row in decided], failures)
        _count_columns(found.measurements, [row.measured for row in decided], failures)
    return found


def _count(found: Summary, row: Row) -> None:
    found.cpu += row.cpu + row.sim_cpu
    if row.host in found.hosts or len(found.hosts) < MOST_GROUPS:
        found.hosts[row.host] += 1
    if row.started:
        found.first = min(found.first or row.started, row.started)
        found.last = max(found.last, row.started)
    has_passed = row.status is End.PASSED
    if not has_passed:
        _group(found.failures, row)
    if not has_passed or row.margin is not None:
        _rank(found.worst, row, has_passed)


def _count_columns(
    columns: dict[str, Column], rows: Sequence[Mapping[str, Any]], failures: Sequence[bool]
) -> None:
    for name in dict.fromkeys(chain.from_iterable(rows)):
        if name in columns or len(columns) < MOST_COLUMNS:
            columns.setdefault(name, Column()).add([row.get(name) for row in rows], failures)


def _sample(found: Summary, row: Row, draw: random.Random) -> None:
    found.decided += 1
    if len(found.sample) < SAMPLE:  # Vitter's algorithm R (ACM TOMS 11, 1985)
        found.sample.append((row.values, row.status is End.FAILED))
    elif (place := int(draw.random() * found.decided)) < SAMPLE:
        found.sample[place] = row.values, row.status is End.FAILED


def _group(groups: dict[tuple[str, str], FailureGroup], row: Row) -> None:
    key = (row.reason_key or row.status.value, row.where)
    if key not in groups and len(groups) >= MOST_GROUPS:
        key = MORE
    group = groups.get(key)
    if group is None:
        group = groups[key] = FailureGroup(row)
    elif row.run < group.example.run:
        group.example = row
    group.count += 1


def _rank(worst: list[tuple[Rank, Row]], row: Row, has_passed: bool) -> None:
    rank = (has_passed, row.margin or 0.0, row.run)
    if len(worst) < MOST_ROWS or rank < worst[-1][0]:
        insort(worst, (rank, row), key=lambda item: item[0])
        del worst[MOST_ROWS:]
