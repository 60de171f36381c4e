"""Small tables of runs for notebooks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from seoro.campaign.runs import End, Row
from seoro.text.notebook import card
from seoro.text.notebook import table_html as in_rows

MOST_ROWS: Final = 10


def table_html(title: str, rows: Sequence[Row], total: int) -> str:
    """Return a table of runs; failed runs and errors come first.

    Args:
        title: Text above it.
        rows: The runs.
        total: Number of all runs.
    """
    shown = sorted(rows, key=lambda row: (row.status is End.PASSED, row.run))
    paths = list(dict.fromkeys(path for row in shown for path in row.values))
    cells = (
        [row.run, row.status.value, *(row.values.get(path, "") for path in paths), row.reason] for row in shown
    )
    table = in_rows(("run", "status", *paths, "reason"), cells) if shown else ""
    more = [f"{total - len(rows):,} more runs"] if total > len(rows) else []
    return card(title, "", {}, more, table)


def row_html(row: Row) -> str:
    """Return a run as a card with its values and measurements."""
    facts = {"seed": row.seed, **row.values, "reason": row.reason, **row.measured}
    return card(f"run {row.run}", row.status.value, facts)
