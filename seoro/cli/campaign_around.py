"""Campaigns around a failed run, for `seoro campaign shrink` and `neighbours`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from seoro.campaign.after.around import ON_ROBOTS, Start
from seoro.campaign.after.same_failure import SameFailure
from seoro.campaign.places import Places, checked_places
from seoro.campaign.runs import End, Row
from seoro.campaign.session import Campaign
from seoro.campaign.strategies.contract import Told
from seoro.cli.arguments import Commands, add_command, add_option
from seoro.cli.campaign_interruption import Interruption
from seoro.cli.campaign_places import add_places
from seoro.concurrency.background import background


def add_around(commands: Commands, name: str, what: str, runs: int) -> argparse.ArgumentParser:
    """Declare a subcommand with the options that both have.

    Args:
        commands: Subcommands of `seoro campaign`.
        name: Its name.
        what: Its description.
        runs: Default of `--runs`.
    """
    parser = add_command(commands, name, what)
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="folder of the campaign")
    parser.add_argument("number", metavar="RUN", help="number of the failed run, or the beginning of its id")
    add_option(parser, "--any-failure", "count all failures, not only those for the same reason at the same place")
    add_option(parser, "--runs N", f"maximum number of runs (default: {runs})", default=runs)
    add_option(
        parser,
        "--repeat N",
        f"runs of the same values, most of which must fail (default: 1, and {ON_ROBOTS} on real robots)",
    )
    add_places(parser)
    return parser


async def carry_out(campaign: Campaign, start: Start, places: Places, show: Callable[[Row], object]) -> bool:
    """Carry out a campaign around a run; returns whether a signal has interrupted it.

    Args:
        campaign: The campaign.
        start: The run.
        places: Places of its runs.
        show: Called with the row of each run that ends.

    Raises:
        UsageError, BackendError: As `Campaign.running`.
    """
    interrupted = Interruption(campaign)
    async with campaign.running(checked_places(places, start.options), show), background() as group:
        group.start_soon(interrupted.listen, group.cancel_scope)
        await campaign.wait()
    return interrupted.has_come


def announce(start: Start) -> None:
    """Print which run it is about."""
    row = start.found.row
    print(f"{start.found.campaign.manifest.shown}: run {row.run}, seed {row.seed}: {row.reason}", flush=True)


def printer(failure: SameFailure) -> Callable[[Row], object]:
    """Return a function that prints how runs ended, beside the failure that was looked for."""

    def show(row: Row) -> None:
        changed = row.strategy.partition(": ")[2] or "the run itself"
        print(f"{row.run:>5}  {failure.ending_of(row):13}  {changed}", flush=True)

    return show


def flaky_text(repeated: Told | None, failure: SameFailure, row: Row) -> str:
    """Describe a failure that did not repeat."""
    assert repeated is not None, "it was repeated"
    rows = repeated.rows
    same = sum(map(failure.matches, rows))
    if len(rows) > 1:
        return (
            f"\nrun {row.run} is flaky: with its values and its seed, {same} of {len(rows)} runs fail the same way"
        )
    if not rows or rows[0].status is not End.FAILED:
        end = rows[0].status.value if rows else "excluded by constraints"
        return f"\nrun {row.run} is flaky: it failed, and with the same values and seed it is {end}"
    return (
        f"\nrun {row.run} fails in another way with the same values and seed: {rows[0].reason}\n"
        "  `--any-failure` counts all failures"
    )
