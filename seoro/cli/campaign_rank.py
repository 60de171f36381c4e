"""`seoro campaign rank`: the fewest runs that keep the coverage of a campaign, also as scenario files."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from seoro.bundle.unpack import read_options
from seoro.campaign.emit import Emitter
from seoro.campaign.emit_options import CONFTEST, place_conftest
from seoro.campaign.opening import check_unchanged
from seoro.campaign.ranking import Ranked, Ranking
from seoro.campaign.runs import Planned, title_of
from seoro.campaign.store.folder import CampaignFile, find_planned, read_campaign, read_rows
from seoro.cli.arguments import Commands, add_command, add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, write_errors
from seoro.cli.tables import table
from seoro.embed.scenarios import load
from seoro.errors import UsageError

RANK: Final = "rank"
SHOWN: Final = 30  # runs in the table


def add_rank(commands: Commands) -> None:
    """Declare the subcommand."""
    parser = add_command(commands, RANK, "choose the fewest runs that keep the coverage of a campaign")
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="folder of the campaign")
    add_option(parser, "--failures", "also choose the first run of each kind of failure, before all others")
    add_option(parser, "--emit DIR", "write the chosen runs as scenario files, for a test suite")
    add_option(parser, "--json", "print the chosen runs as JSON Lines")


def rank(options: argparse.Namespace) -> int:
    """Run the subcommand."""
    folder: Path = options.folder
    campaign, ranking = read_campaign(folder), Ranking(failures=options.failures)
    for row in read_rows(folder):
        ranking.add(row)
    chosen = ranking.chosen()
    if not chosen:
        what = "coverage" if ranking.runs else "run with a verdict"
        raise UsageError(
            f"{folder} has no {what} to keep", help="add `cover` items to the scenario, or use `--failures`"
        )
    planned = find_planned(folder, {each.run for each in chosen})
    if options.json:
        for each in chosen:
            print(json.dumps(_plain(each, planned[each.run])))
    else:
        _print(chosen, ranking, planned, campaign)
    if options.emit is not None:
        files = _emit(campaign, folder, [planned[each.run] for each in chosen], options.emit)
        print(files, file=sys.stderr if options.json else sys.stdout)
    return Exit.PASSED


def _plain(each: Ranked, planned: Planned) -> dict[str, object]:
    return {
        "run": each.run, "new": each.new, "total": each.total, "failure": each.failure, "seed": planned.seed,
        "values": dict(planned.values),
    }  # fmt: skip


def _print(
    chosen: Sequence[Ranked], ranking: Ranking, planned: Mapping[int, Planned], campaign: CampaignFile
) -> None:
    buckets = count(ranking.buckets, "bucket")
    print(f"{campaign.manifest.shown}: {len(chosen)} of {count(ranking.runs, 'run')} keep all {buckets}\n")
    lines = [["run", "new", "total", "seed", "values"]]
    for each in chosen[:SHOWN]:
        run = planned[each.run]
        failure = f"  fails: {each.failure}" if each.failure else ""
        lines.append(
            [str(each.run), str(each.new), str(each.total), str(run.seed), title_of(run.values) + failure]
        )
    print(table(lines, "  ", {0, 1, 2, 3}))
    if len(chosen) > SHOWN:
        print(f"  and {len(chosen) - SHOWN} more; `--json` prints all")


def _emit(campaign: CampaignFile, folder: Path, runs: Sequence[Planned], target: Path) -> str:
    """Write runs as scenario files; returns how to run them.

    Raises:
        UsageError: Files of the scenario have changed, or a file would replace one of the user.
    """
    check_unchanged(campaign, f"runs of {folder} cannot be written", "start another campaign")
    root = Path(campaign.manifest.root or ".")
    options = read_options(campaign.manifest, root)
    stem = Path(campaign.manifest.entry).stem
    with write_errors(target):
        emitter = Emitter(load(root / campaign.manifest.entry), options, target)
        names = [f"{stem}_{run.number:06}.osc" for run in runs]
        emitter.remove_others(stem, names)
        for name, run in zip(names, runs, strict=True):
            emitter.write(name, run.values, run.seed, [f"Run {run.number} of the campaign in {folder}."])
        has_options = place_conftest(options, target)
    lines = [f"{target}/{stem}_*.osc  {count(len(runs))}"]
    lines += [f"{target / CONFTEST}  the options of the campaign"] if has_options else []
    clock = ["--osc-clock", "real"] if options.clock == "real" and not has_options else []
    return "".join(f"\n  {line}" for line in (*lines, shlex.join(["pytest", str(target), *clock])))
