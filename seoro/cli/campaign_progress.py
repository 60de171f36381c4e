"""Progress and results of a campaign, on the terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import datetime
from heapq import nlargest
from itertools import chain
from pathlib import Path
from typing import Final, Protocol

from seoro.campaign.coverage.unreachable import read_unreachable
from seoro.campaign.runs import End, Row
from seoro.campaign.state import State, progress_data
from seoro.campaign.statistics.flaky import RepeatedIds, find_flaky
from seoro.campaign.store.batches import read_batches
from seoro.campaign.store.folder import LOCK, CampaignFile, read_campaign, read_rows
from seoro.cli.campaign_stopping import rate_text
from seoro.cli.results import print_json
from seoro.cli.terminal import is_terminal
from seoro.files.written_files import written_files

PERIOD: Final = 10.0  # [s] between lines, without a terminal
PACE_TIME: Final = 60.0  # [s] before the latest run that are the pace of a running campaign
LATEST: Final = 2000  # of the latest runs, at most
MOST_LINES: Final = 20  # of runs that did not pass; the table has all


class Show(Protocol):
    """Shows the row of a run that has ended."""

    def __call__(self, row: Row) -> None:
        """Show it."""


class Progress:
    """Progress of a session of a campaign.

    Args:
        state: State of the campaign before the session, which the session keeps current.
    """

    def __init__(self, state: State) -> None:
        self._state = state
        self._before = state.tally.runs
        self._total = state.campaign.runs
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
                for line in self._line(row):
                    bar.console.print(line, markup=False, highlight=False)
                bar.update(task, completed=self._state.tally.runs, last=self._counts())

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
        return pace_text(self._state, self._state.tally.runs - self._before, time.monotonic() - self._begun)

    def text(self, *, is_over: bool = False) -> str:
        """Return the progress in one line.

        Args:
            is_over: Whether the campaign was carried out to its end.
        """
        of = f" of {self._total:,}" if self._total is not None else ""
        return f"{self._state.tally.runs:,}{of} runs: {self._counts(is_over=is_over)}"

    def _counts(self, *, is_over: bool = False) -> str:
        rate = rate_text(self._state, is_complete=is_over)
        return f"{self._state.tally.text}{rate}{self._pace()}"


def seeds_text(campaign: CampaignFile) -> str:
    """Describe the seeds of the first point."""
    if campaign.seeds:
        return f"seeds {', '.join(map(str, campaign.seeds))}"
    last = campaign.seed + campaign.repeat - 1
    return f"seed {campaign.seed}" if campaign.repeat == 1 else f"seeds {campaign.seed} to {last}"


def print_status(folder: Path, *, as_json: bool = False) -> None:
    """Print how far a campaign is, and its pace while a process carries it out."""
    starts: list[str] = []
    runs_on = bool(written_files({folder / LOCK}))
    campaign, ids = read_campaign(folder), RepeatedIds()
    state = State(campaign, (), read_unreachable(folder))
    for batch in read_batches(folder):
        state.record_batch(batch)
        ids.add(batch.column("id"))
        starts = nlargest(LATEST, chain(starts, batch.column("started"))) if runs_on else []
    if as_json:
        print_json({**progress_data(state), "is_running": runs_on})
        return
    of = f" of {campaign.runs:,}" if campaign.runs is not None else ""
    counts = f"{state.tally.runs:,}{of} runs: {state.tally.text}"
    pace = _latest_pace(state, starts)
    print(f"{campaign.manifest.shown}: {counts}{rate_text(state, is_complete=state.is_complete)}{pace}")
    if state.watch.stop is not None:
        print(f"  stopped: {state.watch.stop.reason}")
    if campaign.requirements:
        print(f"  requirements: {', '.join(campaign.requirements)}")
    repeated = [row for row in read_rows(folder) if row.id in ids.found] if ids.found else []
    for flaky in find_flaky(sorted(repeated, key=lambda row: row.run)):
        numbers = ", ".join(str(row.run) for row in flaky.rows)
        print(
            f"  runs {numbers} have the same id, but other {'verdicts' if flaky.has_other_verdict else 'traces'}"
        )


def _latest_pace(state: State, starts: Iterable[str]) -> str:
    """Describe the pace of the latest starts of runs."""
    times = sorted(datetime.fromisoformat(each).timestamp() for each in starts if each)
    latest = [each for each in times if times[-1] - each <= PACE_TIME]
    return pace_text(state, len(latest) - 1, latest[-1] - latest[0]) if latest else ""


def pace_text(state: State, runs: int, taken: float) -> str:
    """Describe a pace, and the time left if the number of runs is known; empty without a run.

    Args:
        state: State of the campaign.
        runs: Number of runs.
        taken: Time that they took [s].
    """
    if runs <= 0 or taken <= 0.0:
        return ""
    rate = runs / taken
    text = f", {rate:.1f}/s" if rate >= 1.0 else f", {60.0 * rate:.1f}/min"
    if state.campaign.runs is not None:
        text += f", {_duration((state.campaign.runs - state.tally.runs) / rate)} left"
    return text


def print_files(files: Iterable[Path]) -> None:
    """Print the paths of result files."""
    for path in files:
        print(f"  {path}")


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{max(seconds, 0.0):.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
