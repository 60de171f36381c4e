"""Progress and results of a campaign, on the terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Protocol

from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import End, Row
from seoro.campaign.statistics.flaky import find_flaky
from seoro.campaign.stopping.watch import Watch
from seoro.campaign.store.folder import CampaignFile, read_campaign, read_rows
from seoro.cli.campaign_stopping import rate_text, watch_of
from seoro.cli.output import is_terminal

PERIOD: Final = 10.0  # [s] between lines, without a terminal
MOST_LINES: Final = 20  # of runs that did not pass; the table has all


class Show(Protocol):
    """Shows the row of a run that has ended."""

    def __call__(self, row: Row) -> None:
        """Show it."""


class Progress:
    """Progress of a session of a campaign.

    Args:
        before: Counts of earlier sessions.
        campaign: The campaign.
        watch: Counts its verdicts in order.
    """

    def __init__(self, before: Tally, campaign: CampaignFile, watch: Watch) -> None:
        self.tally = before
        self._campaign = campaign
        self._watch = watch
        self._before = before.runs
        self._total = campaign.runs
        self._begun = time.monotonic()
        self._shown = 0

    @contextmanager
    def showing(self) -> Iterator[Show]:
        """Show rows while the block lasts: a bar on a terminal, otherwise a line now and then."""
        if is_terminal(sys.stdout):
            with self._bar() as show:
                yield show
            return
        last = self._begun

        def show_line(row: Row) -> None:
            nonlocal last
            self._record(row)
            for line in self._line(row):
                print(line, flush=True)
            if time.monotonic() - last > PERIOD:
                last = time.monotonic()
                print(self.text(), flush=True)

        yield show_line

    @contextmanager
    def _bar(self) -> Iterator[Show]:
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn  # noqa: PLC0415 - slow to load
        from rich.progress import Progress as Bar  # noqa: PLC0415 - the same

        with Bar(BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[last]}")) as bar:
            task = bar.add_task("", total=self._total, completed=self._before, last="")

            def show(row: Row) -> None:
                self._record(row)
                for line in self._line(row):
                    bar.console.print(line, markup=False, highlight=False)
                bar.update(task, completed=self.tally.runs, last=self._state())

            yield show

    def _line(self, row: Row) -> Iterator[str]:
        """Yield a line for a run that did not pass, up to a number."""
        if row.status in (End.PASSED, End.IMPOSSIBLE):
            return
        self._shown += 1
        if self._shown <= MOST_LINES:
            values = " ".join(f"{path}={value}" for path, value in row.values.items())
            yield f"{row.run:>6}  {row.status.value:9}  {values}  {row.reason}".rstrip()
        if self._shown == MOST_LINES:
            yield "        more runs that did not pass are in the table only"

    def _pace(self) -> str:
        """Return the rate and the time left, of which nothing is known before the first run."""
        ended, taken = self.tally.runs - self._before, time.monotonic() - self._begun
        if not ended or taken <= 0.0:
            return ""
        rate = ended / taken
        text = f", {rate:.1f}/s" if rate >= 1.0 else f", {60.0 * rate:.1f}/min"
        if self._total is not None:
            text += f", {_duration((self._total - self.tally.runs) / rate)} left"
        return text

    def text(self, *, is_over: bool = False) -> str:
        """Return the progress in one line.

        Args:
            is_over: Whether the campaign was carried out to its end.
        """
        of = f" of {self._total:,}" if self._total is not None else ""
        return f"{self.tally.runs:,}{of} runs: {self._state(is_over=is_over)}"

    def _state(self, *, is_over: bool = False) -> str:
        return f"{self.tally.text}{rate_text(self._campaign, self._watch, is_over=is_over)}{self._pace()}"

    def _record(self, row: Row) -> None:
        self.tally.count(row)
        self._watch.record(row)


def seeds_text(campaign: CampaignFile) -> str:
    """Describe the seeds of the first point."""
    if campaign.seeds:
        return f"seeds {', '.join(map(str, campaign.seeds))}"
    last = campaign.seed + campaign.repeat - 1
    return f"seed {campaign.seed}" if campaign.repeat == 1 else f"seeds {campaign.seed} to {last}"


def print_status(folder: Path) -> None:
    """Print how far a campaign is."""
    campaign, tally = read_campaign(folder), Tally()
    watch, rows = watch_of(campaign), sorted(read_rows(folder), key=lambda row: row.run)
    for row in rows:
        watch.record(row)
        if row.status is not End.IMPOSSIBLE:
            tally.count(row)
    of = f" of {campaign.runs:,}" if campaign.runs is not None else ""
    print(f"{campaign.manifest.shown}: {tally.runs:,}{of} runs: {tally.text}{rate_text(campaign, watch)}")
    if watch.stop is not None:
        print(f"  stopped: {watch.stop.reason}")
    for flaky in find_flaky(rows):
        numbers = ", ".join(str(row.run) for row in flaky.rows)
        print(
            f"  runs {numbers} have the same id, but other {'verdicts' if flaky.has_other_verdict else 'traces'}"
        )


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{max(seconds, 0.0):.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
