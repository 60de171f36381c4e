"""`seoro campaign compare`: is the second of two campaigns worse than the first?"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from seoro.campaign.comparison.comparing import MARGIN, Comparison, Outcome, compare
from seoro.campaign.comparison.data import comparison_data
from seoro.campaign.comparison.measurements import MeasurementChange
from seoro.campaign.comparison.pairs import Pair
from seoro.campaign.comparison.text import number_text, p_text, verdict_lines
from seoro.cli.arguments import Commands, add_command, add_option, share
from seoro.cli.exit_status import Exit
from seoro.cli.files import write_errors
from seoro.cli.tables import table
from seoro.runtime.trace.jsonl import to_json

_MOST: Final = 10  # runs of each list, and measurements
_STATUS: Final = {Outcome.WORSE: Exit.FAILED, Outcome.NOT_WORSE: Exit.PASSED, Outcome.UNDECIDED: Exit.ERROR}
_EPILOG: Final = "exit status: 0 not worse, 1 worse, 2 the command line or a folder is invalid, 3 undecided"


def add_compare(commands: Commands) -> None:
    """Declare the subcommand."""
    parser = add_command(commands, "compare", "compare two campaigns, such as of two versions of a robot")
    parser.epilog = _EPILOG
    parser.add_argument("before", metavar="BEFORE", type=Path, help="folder of the first campaign")
    parser.add_argument("after", metavar="AFTER", type=Path, help="folder of the second campaign")
    add_option(
        parser,
        "--margin SHARE",
        "largest drop of the pass rate that counts as not worse, such as 1%% (default: 2%%)",
        type=share,
        default=MARGIN,
    )
    add_option(parser, "-o --output FILE", "write the comparison as HTML to this file")
    add_option(parser, "--json", "print the comparison as one JSON object")


def run_compare(options: argparse.Namespace) -> int:
    """Run the subcommand."""
    found = compare(options.before, options.after, margin=options.margin)
    if options.output is not None:
        from seoro.campaign.comparison.page import write_comparison  # noqa: PLC0415 - charts, for this option only

        with write_errors(options.output):
            write_comparison(found, options.output)
    if options.json:
        print(to_json(comparison_data(found)))
    else:
        print("\n".join(_lines(found)))
        if options.output is not None:
            print(f"\n  {options.output}")
    return _STATUS[found.outcome]


def _lines(found: Comparison) -> Iterator[str]:
    yield f"{found.outcome.value}: {found.after} compared with {found.before}"
    yield from (f"  {line}" for line in verdict_lines(found))
    for title, pairs in (("newly failing", found.failing), ("newly passing", found.passing), ("lost", found.lost)):
        yield from _runs(title, found, pairs)
    yield from _changes(found.measurements)
    if found.differences:
        yield "\nwhat differs:"
        yield table([(each.name, each.before, each.after) for each in found.differences], indent="  ")


def _runs(title: str, found: Comparison, pairs: Sequence[Pair]) -> Iterator[str]:
    if not pairs:
        return
    yield f"\n{title}: {len(pairs):,}"
    for pair in pairs[:_MOST]:
        values = " ".join(f"{path}={value}" for path, value in pair.values.items())
        yield f"  {values} seed {pair.seed}: {pair.reason}".rstrip(": ")
        yield f"    {found.command(pair)}"
    if len(pairs) > _MOST:
        yield f"  and {len(pairs) - _MOST:,} more"


def _changes(measurements: Sequence[MeasurementChange]) -> Iterator[str]:
    changed = [each for each in measurements if each.rising or each.falling][:_MOST]
    if not changed:
        return
    yield "\nmeasurements of runs that passed in both, by variant:"
    lines = [("", "before", "after", "change", "95 % interval", "")]
    for each in changed:
        before, after, change, low, high = map(
            number_text, (each.before, each.after, each.change, each.bounds.low, each.bounds.high)
        )
        lines.append((each.name, before, after, change, f"{low} to {high}", p_text(each.p)))
    yield table(lines, indent="  ", right={1, 2, 3, 4, 5})
