"""Results of a campaign for its page: rows are read once, in blocks, while the campaign runs.

The blocks of the shards are read in turn, so that the runs are nearly in order.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Final

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.coverage.unreachable import read_unreachable
from seoro.campaign.report.reservoir import Reservoir
from seoro.campaign.report.summary import SAMPLE, Summary, add_batch
from seoro.campaign.runs import End, Row
from seoro.campaign.state import rate_of
from seoro.campaign.stopping.grammar import parse_rule
from seoro.campaign.stopping.rate import Rate
from seoro.campaign.stopping.rules import CoverageGoal
from seoro.campaign.stopping.watch import Watch
from seoro.campaign.store.batches import Batch
from seoro.campaign.store.folder import CAMPAIGN, CampaignFile, read_campaign, shards_of
from seoro.campaign.store.lines import read_blocks

MOST_LATEST: Final = 50  # runs that did not pass


class KnownRuns:
    """Numbers of runs, most of which are consecutive from 1 on."""

    def __init__(self) -> None:
        self._next = 1
        self._early: set[int] = set()

    def add(self, run: int) -> bool:
        """Add a run; returns whether it is new."""
        if run < self._next or run in self._early:
            return False
        self._early.add(run)
        while self._next in self._early:
            self._early.remove(self._next)
            self._next += 1
        return True


class CampaignReader:
    """Reads the rows of a campaign.

    Args:
        folder: Folder of the campaign.

    Attributes:
        campaign: Content of its `campaign.json`.
        summary: Summary of the rows that were read.
        latest: Runs that did not pass, the latest start first.

    Raises:
        UsageError: The folder is not that of a campaign.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._begin()

    def _begin(self) -> None:
        self._stamp = _stamp(self.folder / CAMPAIGN)
        self.campaign: CampaignFile = read_campaign(self.folder)
        coverage = MergedCoverage(self.campaign.items, read_unreachable(self.folder))
        self.summary = Summary(coverage=coverage, sample=Reservoir(SAMPLE, self.campaign.seed))
        rules = [rule for rule in map(parse_rule, self.campaign.until) if not isinstance(rule, CoverageGoal)]
        self._watch = Watch(rules)
        self._known = KnownRuns()
        self._latest: list[tuple[tuple[str, int], Row]] = []
        self._read: dict[Path, int] = {}  # position behind the last line [bytes]

    @property
    def latest(self) -> Sequence[Row]:
        """Runs that did not pass, the latest start first."""
        return [row for _, row in reversed(self._latest)]

    @property
    def rate(self) -> Rate:
        """Pass rate of the runs before the first that has not ended."""
        return rate_of(self.campaign, self._watch, is_complete=False)

    @property
    def stop(self) -> str:
        """Reason why a rule about verdicts ends the campaign; empty without one."""
        return "" if self._watch.stop is None else self._watch.stop.reason

    def read_new(self) -> Iterator[int]:
        """Read new rows, in blocks; yields the number of bytes after each.

        If the campaign was replaced by another, everything is read again.

        Raises:
            UsageError: A row or `campaign.json` is invalid.
            OSError: A file cannot be read.
        """
        if _stamp(self.folder / CAMPAIGN) != self._stamp:  # also if it was extended
            before = self.campaign
            self.campaign = read_campaign(self.folder)
            if before.model_copy(update={"runs": None, "is_extended": False}) != self.campaign.model_copy(
                update={"runs": None, "is_extended": False}
            ):
                self._begin()
            self._stamp = _stamp(self.folder / CAMPAIGN)
        shards = shards_of(self.folder)
        if any(_size(path) < start for path, start in self._read.items()):
            self._begin()
        reading = {path: read_blocks(path, self._read.get(path, 0)) for path in shards}
        while reading:
            for path, blocks in list(reading.items()):
                lines = next(blocks, None)
                if lines is None:
                    del reading[path]
                    continue
                start = self._read.get(path, 0)
                self._add(Batch(lines, partial(_place, path, start)))
                size = sum(map(len, lines))
                self._read[path] = start + size
                yield size

    def _add(self, batch: Batch) -> None:
        runs = batch.column("run")
        new = [position for position, run in enumerate(runs) if self._known.add(run)]
        if len(new) < len(runs):
            batch = batch.select(new)
        add_batch(self.summary, batch)
        self._watch.record_batch(batch)
        self._note_latest(batch)

    def _note_latest(self, batch: Batch) -> None:
        started, runs = batch.column("started"), batch.column("run")
        for end, positions in batch.ends.items():
            if end in (End.PASSED, End.IMPOSSIBLE):
                continue
            for position in positions:
                order = (started[position], runs[position])
                if len(self._latest) < MOST_LATEST or order > self._latest[0][0]:
                    insort(self._latest, (order, batch.row(position)), key=lambda each: each[0])
                    del self._latest[:-MOST_LATEST]


def _stamp(path: Path) -> tuple[int, int] | None:
    with suppress(OSError):
        found = path.stat()
        return found.st_ino, found.st_mtime_ns
    return None


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _place(path: Path, start: int, position: int) -> str:
    return f"{path}: line {position + 1} after byte {start}"
