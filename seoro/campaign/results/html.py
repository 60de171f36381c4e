"""Small tables of runs for notebooks."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Final

from seoro.campaign.runs import End, Row

MOST_ROWS: Final = 10
_LETTERS: Final = 120  # of a cell


def table_html(title: str, rows: Sequence[Row], total: int) -> str:
    """Return a table of runs; failed runs and errors come first.

    Args:
        title: Text above it.
        rows: The runs.
        total: Number of all runs.
    """
    shown = sorted(rows, key=lambda row: (row.status is End.PASSED, row.run))
    paths = list(dict.fromkeys(path for row in shown for path in row.values))
    lines = [_line([str(row.run), row.status.value, *_values(row, paths), row.reason]) for row in shown]
    head = _line(["run", "status", *paths, "reason"], "th")
    more = f"<p>{total - len(rows):,} more runs</p>" if total > len(rows) else ""
    table = f"<table>{head}{''.join(lines)}</table>" if shown else ""
    return f"<p><b>{escape(title)}</b></p>{table}{more}"


def row_html(row: Row) -> str:
    """Return a run as a table of its values and measurements."""
    facts = {
        "run": row.run,
        "status": row.status.value,
        "seed": row.seed,
        **row.values,
        "reason": row.reason,
        **{name: value for name, value in row.measured.items() if value is not None},
    }
    return f"<table>{''.join(_line([name, _text(value)]) for name, value in facts.items())}</table>"


def _values(row: Row, paths: Sequence[str]) -> list[str]:
    return [_text(row.values.get(path, "")) for path in paths]


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _line(cells: Sequence[str], kind: str = "td") -> str:
    return f"<tr>{''.join(f'<{kind}>{escape(cell[:_LETTERS])}</{kind}>' for cell in cells)}</tr>"
