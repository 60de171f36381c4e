"""The rows of a campaign in order, each run once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import read_rows


def final_rows(folder: Path) -> Iterator[Row]:
    """Yield the rows of all runs, by number; of a run with several rows, as after a kill, the last in its shard.

    Args:
        folder: Folder of the campaign.

    Raises:
        UsageError: A row is invalid.
    """
    rows = {row.run: row for row in read_rows(folder) if row.status is not End.IMPOSSIBLE}
    for number in sorted(rows):
        yield rows[number]
