"""Table of the runs, `runs.csv`: a line for each, with parameters, status, measurements and how it was made."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Final

from seoro.campaign.runs import Row

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


def write_table(rows: Sequence[Row], folder: Path) -> Path:
    """Write the table of a campaign.

    Args:
        rows: Its rows, see `final_rows`.
        folder: Its folder.

    Returns:
        The table.

    Raises:
        OSError: The table cannot be written.
    """
    parameters, measurements = columns_of(rows)
    path = folder / TABLE
    with path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        writer = csv.writer(file)
        writer.writerow([*BEFORE, *parameters, *AFTER, *measurements])
        for row in rows:
            writer.writerow(_line(row, parameters, measurements))
    return path


def columns_of(rows: Iterable[Row]) -> tuple[Sequence[str], Sequence[str]]:
    """Return the parameters that vary, and the measurements, each in the order of their first occurrence."""
    parameters: dict[str, None] = {}
    measurements: dict[str, None] = {}
    for row in rows:
        parameters.update(dict.fromkeys(row.values))
        measurements.update(dict.fromkeys(row.measured))
    return tuple(parameters), tuple(measurements)


def _line(row: Row, parameters: Sequence[str], measurements: Sequence[str]) -> list[Any]:
    before = [row.status.value if name == "status" else getattr(row, name) for name in BEFORE]
    return [
        *before,
        *(row.values.get(path) for path in parameters),
        *(getattr(row, name) for name in AFTER),
        *(row.measured.get(column) for column in measurements),
    ]
