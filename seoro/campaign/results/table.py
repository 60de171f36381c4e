"""Table of the runs, `runs.csv`: a line for each, with parameters, status, measurements and how it was made."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, Final, TypeAlias

from seoro.campaign.runs import Row
from seoro.campaign.store.index import RowIndex

TABLE: Final = "runs.csv"
BEFORE: Final = (
    "run",
    "id",
    "variant",
    "repeat",
    "seed",
    "status",
)  # then a column for each parameter that varies
AFTER: Final = (
    "duration", "wall_duration", "cpu", "sim_cpu", "reason", "reason_key", "where", "margin", "strategy", "parent",
    "attempt", "host", "worker", "started", "version", "folder", "trace_sha",
)  # fmt: skip # then measurements

_FIRST: Final = 1000  # rows that usually have all columns
_Columns: TypeAlias = tuple[Sequence[str], Sequence[str]]


def write_table(rows: RowIndex, folder: Path) -> Path:
    """Write the table of a campaign.

    Args:
        rows: Its rows.
        folder: Its folder.

    Returns:
        The table.

    Raises:
        OSError: The table cannot be written.
    """
    path = folder / TABLE
    columns = columns_of(islice(rows, _FIRST))
    if not _write(rows, columns, path):  # a later run has more
        _write(rows, columns_of(rows), path)
    return path


def columns_of(rows: Iterable[Row]) -> _Columns:
    """Return the parameters that vary, and the measurements, each in the order of their first occurrence."""
    parameters: dict[str, None] = {}
    measurements: dict[str, None] = {}
    for row in rows:
        parameters.update(dict.fromkeys(row.values))
        measurements.update(dict.fromkeys(row.measured))
    return tuple(parameters), tuple(measurements)


def _write(rows: Iterable[Row], columns: _Columns, path: Path) -> bool:
    """Write a table with these columns; returns False at the first row that has others."""
    parameters, measurements = columns
    known = set(parameters), set(measurements)
    with path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        writer = csv.writer(file)
        writer.writerow(header(parameters, measurements))
        for row in rows:
            if not row.values.keys() <= known[0] or not row.measured.keys() <= known[1]:
                return False
            writer.writerow(cells(row, parameters, measurements))
    return True


def header(parameters: Sequence[str], measurements: Sequence[str]) -> list[str]:
    """Return the names of all columns; see `columns_of`."""
    return [*BEFORE, *parameters, *AFTER, *measurements]


def cells(row: Row, parameters: Sequence[str], measurements: Sequence[str]) -> list[Any]:
    """Return the line of a run; None for missing values."""
    before = [row.status.value if name == "status" else getattr(row, name) for name in BEFORE]
    return [
        *before,
        *(row.values.get(path) for path in parameters),
        *(getattr(row, name) for name in AFTER),
        *(row.measured.get(column) for column in measurements),
    ]
