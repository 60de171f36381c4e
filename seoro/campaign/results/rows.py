"""The rows of a campaign in order."""

from __future__ import annotations

from pathlib import Path

from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import read_rows


def final_rows(folder: Path) -> tuple[Row, ...]:
    """Return the rows of all runs in order; runs that constraints exclude are left out.

    Args:
        folder: Folder of the campaign.

    Raises:
        UsageError: A row is invalid.
    """
    rows = (row for row in read_rows(folder) if row.status is not End.IMPOSSIBLE)
    return tuple(sorted(rows, key=lambda row: row.run))
