"""`seoro campaign neighbours`: how far away from a failed run it passes, in the direction of each parameter."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Final

import anyio

from seoro.campaign.after.around import Start, open_around, start_at
from seoro.campaign.after.finding import find_failed
from seoro.campaign.after.neighbourhood import Direction, Neighbourhood
from seoro.campaign.store.folder import NEIGHBOURS, StrategyText
from seoro.cli.arguments import Commands
from seoro.cli.campaign_around import add_around, announce, carry_out, flaky_text, printer, repeats_of
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
    failure = start.failure(any_failure=options.any_failure)
    strategy = Neighbourhood(start.found.row.run, start.values, failure)
    text = StrategyText(name=NEIGHBOURS, options={"any_failure": options.any_failure})
    repeat = repeats_of(options, start)
    with write_errors(start.found.folder):
        folder = open_around(start, NEIGHBOURS, text, options.runs, repeat)
    announce(start)
    is_interrupted = await carry_out(folder, start, strategy, places_of(options), printer(failure))
    if strategy.repeated is not None and not strategy.has_repeated:
        print(flaky_text(strategy.repeated, failure, start.found.row))
        return Exit.FAILED
    if strategy.has_repeated:
        print(f"\n{table([*_lines(strategy, start)], '  ')}")
    if is_interrupted:
        print(f"  continue with the same command; its runs are in {folder.folder}")
        return Exit.INTERRUPTED
    return Exit.PASSED


def _lines(strategy: Neighbourhood, start: Start) -> Iterator[list[str]]:
    yield ["parameter", f"run {start.found.row.run}", "below", "above", "matters"]
    for path, value in strategy.values.items():
        matters = "yes" if strategy.matters(path) else "no"
        if path in strategy.others:
            endings = [f"{ending or 'not run'} with {text}" for text, ending in strategy.others[path].items()]
            yield [path, value, ", ".join(endings), "", matters]
        else:
            below, above = strategy.directions[path]
            yield [path, value, _text(below), _text(above), matters]


def _text(direction: Direction | None) -> str:
    """Describe a direction; None if the run has the last value."""
    if direction is None:
        return "-"
    if direction.end is None:
        return f"fails to {direction.failing}"
    return f"{direction.ending} at {direction.end}"
