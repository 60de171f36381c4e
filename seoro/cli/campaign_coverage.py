"""`seoro campaign coverage`: the coverage of campaigns, with lacking and unreachable buckets."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from seoro.bundle.unpack import read_options
from seoro.campaign.coverage.counts import ItemCounts, MergedCoverage, failing
from seoro.campaign.coverage.merging import coverage_of
from seoro.campaign.coverage.unreachable import note_unreachable
from seoro.campaign.opening import check_unchanged, space_of
from seoro.campaign.stopping.rules import percent
from seoro.campaign.store.folder import read_campaign
from seoro.cli.arguments import Commands, add_command, add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, write_errors
from seoro.embed.scenarios import check_file
from seoro.errors import SeoroError

MOST: Final = 8  # buckets of a line


def add_coverage(commands: Commands) -> None:
    """Declare the subcommand."""
    parser = add_command(commands, "coverage", "show what the runs of campaigns have covered")
    parser.add_argument(
        "folders", metavar="FOLDER", type=Path, nargs="+", help="folders of campaigns; several are added up"
    )
    add_option(parser, "--json", "print the coverage as JSON")


def print_coverage(options: argparse.Namespace) -> int:
    """Run the subcommand."""
    for folder in options.folders:
        _refresh(folder)
    merged = coverage_of(options.folders)
    if options.json:
        print(json.dumps(_plain(merged), indent=2))
        return Exit.PASSED
    if not merged.items:
        print("the scenario has no `cover` items")
        return Exit.PASSED
    for item in merged.items.values():
        print(_title(item))
        for line in _details(item):
            print(f"  {line}")
    if merged.share:
        print(f"coverage: {percent(merged.share)} of all reachable buckets")
    return Exit.PASSED


def _refresh(folder: Path) -> None:
    """Find what constraints exclude among the buckets without a sample, if the scenario is the same as then."""
    campaign = read_campaign(folder)
    manifest = campaign.manifest
    root = Path(manifest.root or ".")
    try:
        check_unchanged(campaign, "unreachable buckets are unknown", "restore the files")
        scenario = check_file(root / manifest.entry, name=manifest.shown).without_errors()
        inputs = space_of(scenario, read_options(manifest, root)).inputs
    except SeoroError as error:
        print(f"note: {str(error).splitlines()[0]}")
        return
    if inputs is not None:
        with write_errors(folder):
            note_unreachable(folder, inputs, coverage_of([folder]))


def _title(item: ItemCounts) -> str:
    if item.reachable is None:
        return f"{item.item}: {len(item.buckets):,} different values"
    text = f"{item.item}: {item.reached:,} of {item.reachable:,} buckets"
    if item.needed > 1:
        text += f" with at least {item.needed:,} samples"
    excluded = sum(map(len, item.excluded.values()))
    return f"{text}, {excluded:,} unreachable" if excluded else text


def _details(item: ItemCounts) -> Iterator[str]:
    if item.illegal:
        yield f"illegal: {count(item.illegal, 'value')}"
    if item.holes:
        yield f"lacking: {_some(item.holes, item.unit)}"
    for reasons, buckets in item.excluded.items():
        yield f"unreachable: {_some(buckets, item.unit)}, by {' and '.join(reasons) or 'the type'}"
    for bucket, counts in failing(item)[:MOST]:
        yield f"failed: {counts.failed:,} of {count(counts.runs, 'run')} in {bucket}, the first is {counts.first}"
    if item.outside:
        yield f"outside of all buckets: {count(item.outside, 'sample')}"


def _some(buckets: Sequence[str], unit: str) -> str:
    more = f" and {len(buckets) - MOST:,} more" if len(buckets) > MOST else ""
    return f"{', '.join(buckets[:MOST])}{more}{f' {unit}' if unit else ''}"


def _plain(merged: MergedCoverage) -> dict[str, Any]:
    return {"coverage": merged.share, "items": [_item(each) for each in merged.items.values()]}


def _item(item: ItemCounts) -> dict[str, Any]:
    return {
        "item": item.item,
        "unit": item.unit,
        "target": item.target,
        "total": item.total,
        "reachable": item.reachable,
        "reached": item.reached,
        "illegal": item.illegal,
        "outside": item.outside,
        "buckets": {
            bucket: {
                "samples": counts.samples,
                "passed": counts.passed,
                "failed": counts.failed,
                "first": counts.first,
            }
            for bucket, counts in item.buckets.items()
        },
        "lacking": item.holes,
        "unreachable": {bucket: list(reasons) for reasons, buckets in item.excluded.items() for bucket in buckets},
    }
