"""Search for a run of a campaign, by its number or its id."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.store.folder import CampaignFile, find_planned, read_campaign, read_rows
from seoro.campaign.store.index import RowIndex
from seoro.errors import UsageError
from seoro.lang.frozen import Value

SHOWN: Final = 10  # runs in a message
LEAST: Final = 4  # digits of an id


class FoundRun(Value):
    """Run of a campaign.

    Args:
        folder: Folder of the campaign.
        campaign: Content of its `campaign.json`.
        planned: The planned run.
        row: Its end.
    """

    folder: Path
    campaign: CampaignFile
    planned: Planned
    row: Row


def find_run(folder: Path, text: str) -> FoundRun:
    """Find a run that has ended.

    Args:
        folder: Folder of the campaign.
        text: Number of the run, or the beginning of its id.

    Raises:
        UsageError: The folder is not that of a campaign, or the run is unknown, ambiguous or excluded.
    """
    campaign = read_campaign(folder)
    row = _find_row(folder, text.lower())
    if row.status is End.IMPOSSIBLE:
        raise UsageError(f"run {row.run} of {folder} did not begin: constraints exclude its values")
    planned = find_planned(folder, {row.run}).get(row.run)
    if planned is None:
        raise UsageError(f"{folder} has no plan of run {row.run}", help="`asked.jsonl` is incomplete")
    return FoundRun(folder, campaign, planned, row)


def find_failed(folder: Path, text: str) -> FoundRun:
    """Find a run that failed.

    Raises:
        UsageError: As `find_run`, or the run has not failed.
    """
    found = find_run(folder, text)
    row = found.row
    if row.status is End.FAILED:
        return found
    reason = f": {row.reason}" if row.reason and row.status is not End.PASSED else ""
    what = "passed" if row.status is End.PASSED else f"ended without a verdict ({row.status.value}){reason}"
    failed = sorted(each.run for each in read_rows(folder) if each.status is End.FAILED)
    raise UsageError(
        f"run {row.run} of {folder} {what}; expected a failed run",
        help=f"failed runs: {_listed(failed)}" if failed else "no run of this campaign failed",
    )


def _find_row(folder: Path, text: str) -> Row:
    if not text or not set(text) <= set("0123456789abcdef"):
        raise UsageError(f"invalid run `{text}`: expected its number, or the beginning of its id")
    number = int(text) if text.isdecimal() else 0
    if number and (found := RowIndex(folder).find(number)) is not None:
        return found
    alike: list[Row] = []
    last = 0
    for row in read_rows(folder):
        if row.run == number:
            return row
        last = max(last, row.run)
        if len(text) >= LEAST and row.id.startswith(text):
            alike.append(row)
    if len({row.id for row in alike}) > 1:
        runs = _listed(sorted(row.run for row in alike))
        raise UsageError(f"several runs have an id that begins with `{text}`: runs {runs}")
    if not alike:
        known = f"its runs that have ended are numbered up to {last}" if last else "no run has ended"
        raise UsageError(f"unknown run `{text}` of {folder}", help=known)
    return min(alike, key=lambda row: row.run)


def _listed(numbers: Sequence[int] | Iterable[int]) -> str:
    shown = [str(number) for number in numbers]
    return ", ".join(shown[:SHOWN]) + (", ..." if len(shown) > SHOWN else "")
