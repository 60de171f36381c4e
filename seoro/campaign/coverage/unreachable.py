"""Buckets that constraints exclude, with these constraints: `unreachable.jsonl` in the folder of a campaign."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.coverage.drawing import Excluded, InputSpace
from seoro.campaign.store.covered import Unreachable
from seoro.campaign.store.folder import UNREACHABLE
from seoro.campaign.store.lines import read_lines
from seoro.errors import UsageError

MOST: Final = 2000  # bins that the solver is asked about, each for some milliseconds
_SEED: Final = 0  # whether values exist does not depend on it


def find_unreachable(inputs: InputSpace, lacking: Iterable[tuple[str, str]]) -> Iterator[Unreachable]:
    """Yield the buckets that constraints exclude among some, at most `MOST` of which are examined.

    Args:
        inputs: Bins of the scenario.
        lacking: Items and buckets without a sample; outputs are left out.
    """
    bins = {(each.item, each.bucket): each for each in inputs.bins}
    wanted = [key for key in lacking if key in bins]
    for key in wanted[:MOST]:
        try:
            inputs.draw(bins[key], _SEED)
        except Excluded as excluded:
            yield Unreachable(item=key[0], bucket=key[1], reasons=excluded.reasons)


def note_unreachable(folder: Path, inputs: InputSpace, coverage: MergedCoverage) -> None:
    """Find and write the buckets that constraints exclude among those without a sample.

    Args:
        folder: Folder of the campaign.
        inputs: Bins of the scenario.
        coverage: Coverage of its runs.

    Raises:
        OSError: The file cannot be written.
    """
    if inputs.bins:
        found = list(find_unreachable(inputs, coverage.lacking()))
        _write(folder, found)
        coverage.exclude(found)


def _write(folder: Path, found: Iterable[Unreachable]) -> None:
    written = folder / f".{UNREACHABLE}"
    written.write_text("".join(f"{each.model_dump_json()}\n" for each in found), encoding="utf-8")
    written.replace(folder / UNREACHABLE)


def read_unreachable(folder: Path) -> tuple[Unreachable, ...]:
    """Read the buckets that constraints exclude; none if they are unknown.

    Raises:
        UsageError: The file is invalid.
    """
    path = folder / UNREACHABLE
    try:
        return tuple(Unreachable.model_validate_json(line) for line in read_lines(path))
    except ValidationError as error:
        raise UsageError(
            f"{path}: invalid line", help="delete the file; `seoro campaign coverage` writes it again"
        ) from error
