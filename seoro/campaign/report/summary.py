"""Summary of the rows of a campaign: one pass, in constant memory."""

from __future__ import annotations

import random
from bisect import insort
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import field
from typing import Any, Final, TypeAlias

from seoro.campaign.report.columns import Column
from seoro.campaign.report.coverage import MergedCoverage
from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import End, Row
from seoro.lang.lazy_dataclass import lazy_dataclass

MOST_ROWS: Final = 500  # in the table of runs
MOST_GROUPS: Final = 200  # of failures; more are counted as one
MOST_COLUMNS: Final = 200  # of parameters, and of measurements
SAMPLE: Final = 20_000  # runs for pairs of parameters
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
    cpu: float = 0.0
    first: str = ""
    last: str = ""

    @property
    def decided(self) -> int:
        """Number of runs that passed or failed."""
        return self.ends[End.PASSED] + self.ends[End.FAILED]


def summarize(rows: Iterable[Row], seed: int) -> Summary:
    """Summarize the rows of a campaign.

    Args:
        rows: A row for each run, in any order.
        seed: Seed of the random sample for pairs of parameters.
    """
    found, draw = Summary(), random.Random(seed)  # noqa: S311 - a sample
    for row in rows:
        found.count(row)
        if row.status is End.IMPOSSIBLE:
            continue
        _count(found, row)
        if row.status in (End.PASSED, End.FAILED):
            _count_decided(found, row, draw)
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


def _count_decided(found: Summary, row: Row, draw: random.Random) -> None:
    for columns, values in ((found.parameters, row.values), (found.measurements, row.measured)):
        for name, value in values.items():
            column = columns.get(name)
            if column is None:
                if len(columns) >= MOST_COLUMNS:
                    continue
                column = columns[name] = Column()
            if value is not None:
                column.add(value, row.status)
    found.coverage.add(row.coverage)
    single = (row.values, row.status is End.FAILED)
    if len(found.sample) < SAMPLE:  # Vitter's algorithm R (ACM TOMS 11, 1985)
        found.sample.append(single)
    elif (place := int(draw.random() * found.decided)) < SAMPLE:
        found.sample[place] = single


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
