"""Shrinking of a failed run in a campaign below that of the run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from seoro.campaign.after.around import Start, open_around, repeats_for, start_at
from seoro.campaign.after.finding import find_failed
from seoro.campaign.after.findings import Shrunk, write_finding
from seoro.campaign.after.shrinking import Outcome, Shrinking
from seoro.campaign.emit import Emitted, Emitter
from seoro.campaign.places import Places, checked_places
from seoro.campaign.runs import Row
from seoro.campaign.session import Campaign
from seoro.campaign.store.folder import SHRINK, StrategyText
from seoro.embed.arguments import AnyPath, to_path

RUNS: Final = 200


class Shrink:
    """Campaign that shrinks a failed run; in a running event loop.

    Args:
        start: The run.
        any_failure: Whether all failures count, not only those for the same reason at the same place.
        runs: Maximum number of runs.
        repeat: Runs of the same values; None for one, and more on real robots.

    Raises:
        UsageError: Another process shrinks this run.
        OSError: The folder cannot be written.
    """

    def __init__(
        self, start: Start, *, any_failure: bool = False, runs: int = RUNS, repeat: int | None = None
    ) -> None:
        self.start = start
        self.failure = start.failure(any_failure=any_failure)
        self.strategy = Shrinking(start.found.row.run, start.values, self.failure)
        text = StrategyText(name=SHRINK, options={"any_failure": any_failure})
        folder = open_around(start, SHRINK, text, runs, repeats_for(start.options, repeat))
        self.campaign = Campaign(folder, start.space, strategy=self.strategy)

    def conclude(self) -> Shrunk:
        """Write the results, and return the simplest failing values.

        Raises:
            OSError: A file cannot be written.
        """
        strategy, row = self.strategy, self.start.found.row
        has_failed = strategy.outcome in (Outcome.FAILING, Outcome.MINIMAL)
        shrunk = Shrunk(
            run=row.run,
            reason=row.reason,
            before=self.start.values,
            values=strategy.values,
            simplest=strategy.simplest,
            outcome=strategy.outcome.value,
            best=strategy.best if has_failed else 0,
        )
        self.campaign.write()
        write_finding(self.campaign.folder, shrunk)
        return shrunk

    def write(self, file: Path) -> Emitted:
        """Write a scenario file with the present values.

        Raises:
            UsageError: It would replace a file of the user.
            OSError: It cannot be written.
        """
        row = self.start.found.row
        note = [
            f"Run {row.run} of the campaign in {self.start.found.folder}, with simpler values. It fails:",
            " ".join(row.reason.split()),
        ]
        emitter = Emitter(self.start.scenario, self.start.options, file.parent)
        return emitter.write(file.name, self.strategy.values, row.seed, note)


async def shrink(
    folder: AnyPath,
    run: int | str | Row,
    *,
    any_failure: bool = False,
    runs: int = RUNS,
    repeat: int | None = None,
    jobs: int | None = None,
    on: Sequence[str] = (),
    executor: str | None = None,
    file: AnyPath | None = None,
) -> Shrunk:
    """Find the simplest values at which a failed run of a campaign still fails, as `seoro campaign shrink`.

    Args:
        folder: Folder of the campaign.
        run: The run: its number, the beginning of its id, or its row.
        any_failure: Whether all failures count, not only those for the same reason at the same place.
        runs: Maximum number of runs.
        repeat: Runs of the same values, most of which must fail; None for one, and more on real robots.
        jobs: Number of simultaneous runs; None for one per processor.
        on, executor: As of `start`.
        file: Scenario file to write, which runs by itself; None for none.

    Raises:
        UsageError: The run is unknown or has not failed, or its scenario has changed.
        BackendError: No process can be started.
        OSError: A file cannot be written.
    """
    text = str(run.run if isinstance(run, Row) else run)
    start = start_at(find_failed(to_path("folder", folder), text))
    places = checked_places(Places(jobs, tuple(on), executor), start.options)
    work = Shrink(start, any_failure=any_failure, runs=runs, repeat=repeat)
    async with work.campaign.running(places):
        await work.campaign.wait()
    shrunk = work.conclude()
    if file is not None and shrunk.has_failed:
        work.write(to_path("file", file))
    return shrunk
