"""Campaigns around a failed run, for `seoro campaign shrink` and `neighbours`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from seoro.campaign.after.around import ON_ROBOTS, Start
from seoro.campaign.after.same_failure import SameFailure
from seoro.campaign.jobs import simultaneous_runs
from seoro.campaign.places import Places
from seoro.campaign.runs import End, Row
from seoro.campaign.session import Campaign
from seoro.campaign.store.folder import CampaignFolder
from seoro.campaign.strategies.contract import Strategy
from seoro.cli.arguments import Commands, add_command, add_option
from seoro.cli.campaign_interruption import Interruption
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
    add_option(parser, "-j --jobs N", "number of simultaneous runs (default: number of processors)")
    return parser


def repeats_of(options: argparse.Namespace, start: Start) -> int:
    """Return the number of runs of the same values: one where runs repeat to the bit."""
    if options.repeat is not None:
        return int(options.repeat)
    settings = start.options
    is_virtual = settings.clock in ("virtual", "sim") or (
        settings.clock is None and settings.simulator is not None
    )
    return 1 if is_virtual and settings.ros is None and settings.lab is None else ON_ROBOTS


async def carry_out(
    folder: CampaignFolder, start: Start, strategy: Strategy, jobs: int | None, show: Callable[[Row], object]
) -> bool:
    """Carry out a campaign around a run; returns whether a signal has interrupted it.

    Args:
        folder: Its folder, which is closed.
        start: The run.
        strategy: Chooses the values.
        jobs: Number of simultaneous runs; None for one per processor.
        show: Called with the row of each run that ends.

    Raises:
        UsageError, BackendError: As `Campaign.running`.
    """
    campaign = Campaign(folder, start.space, strategy=strategy)
    interrupted = Interruption(campaign)
    async with campaign.running(Places(simultaneous_runs(start.options, jobs)), show), background() as group:
        group.start_soon(interrupted.listen, group.cancel_scope)
        await campaign.wait()
    campaign.write()
    return interrupted.has_come


def ending_of(row: Row, failure: SameFailure) -> str:
    """Describe how a run ended, beside the failure that was looked for."""
    match row.status:
        case End.FAILED:
            return "fails" if failure.matches(row) else "other failure"
        case End.PASSED:
            return "passes"
        case End.IMPOSSIBLE:
            return "excluded"
        case End.ERROR | End.CANCELLED:
            return str(row.status.value)
