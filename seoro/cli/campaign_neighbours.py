"""`seoro campaign neighbours`: how far away from a failed run it passes, in the direction of each parameter."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Final

import anyio

from seoro.campaign.after.around import open_around, repeats_for, start_at
from seoro.campaign.after.finding import find_failed
from seoro.campaign.after.findings import Surrounding, Surroundings, write_finding
from seoro.campaign.after.neighbourhood import Direction, Neighbourhood
from seoro.campaign.session import Campaign
from seoro.campaign.store.folder import NEIGHBOURS, StrategyText
from seoro.cli.arguments import Commands
from seoro.cli.campaign_around import add_around, announce, carry_out, flaky_text, printer
from seoro.cli.campaign_places import places_of
from seoro.cli.exit_status import Exit
from seoro.cli.files import write_errors
from seoro.cli.tables import table

RUNS: Final = 500


def add_neighbours(commands: Commands) -> None:
    """Declare the subcommand."""
    add_around(
        commands, NEIGHBOURS, "find how far each parameter is from a value at which a failed run passes", RUNS
    )


def neighbours(options: argparse.Namespace) -> int:
    """Run the subcommand."""
    return anyio.run(_neighbours, options)


async def _neighbours(options: argparse.Namespace) -> int:
    start = start_at(find_failed(options.folder, options.number))
    row = start.found.row
    failure = start.failure(any_failure=options.any_failure)
    strategy = Neighbourhood(row.run, start.values, failure)
    text = StrategyText(name=NEIGHBOURS, options={"any_failure": options.any_failure})
    with write_errors(start.found.folder):
        folder = open_around(start, NEIGHBOURS, text, options.runs, repeats_for(start.options, options.repeat))
    campaign = Campaign(folder, start.space, strategy=strategy)
    announce(start)
    is_interrupted = await carry_out(campaign, start, places_of(options), printer(failure))
    with write_errors(folder.folder):
        campaign.write()
        if strategy.has_repeated:
            found = Surroundings(run=row.run, reason=row.reason, parameters=tuple(_surroundings(strategy)))
            write_finding(folder.folder, found)
            _print(found)
    if is_interrupted:
        print(f"  continue with the same command; its runs are in {folder.folder}")
        return Exit.INTERRUPTED
    if not strategy.has_repeated:
        print(flaky_text(strategy.repeated, failure, row))
        return Exit.FAILED
    return Exit.PASSED


def _print(found: Surroundings) -> None:
    lines = [["parameter", f"run {found.run}", "below", "above", "matters"]]
    for each in found.parameters:
        lines.append([each.path, each.value, each.below, each.above, "yes" if each.matters else "no"])
    print(f"\n{table(lines, '  ')}")


def _surroundings(strategy: Neighbourhood) -> Iterator[Surrounding]:
    for path, value in strategy.values.items():
        if path in strategy.others:
            endings = [f"{ending or 'not run'} with {text}" for text, ending in strategy.others[path].items()]
            below, above = ", ".join(endings), ""
        else:
            below, above = map(_text, strategy.directions[path])
        yield Surrounding(path=path, value=value, below=below, above=above, matters=strategy.matters(path))


def _text(direction: Direction | None) -> str:
    """Describe a direction; None if the run has the last value."""
    if direction is None:
        return "-"
    if direction.end is None:
        return f"fails to {direction.failing}"
    return f"{direction.ending} at {direction.end}"
