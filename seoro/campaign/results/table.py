"""Table of the runs, `runs.csv`: a line for each, with parameters, status, measurements and how it was made."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Any, Final, TypeAlias

from seoro.campaign.store.batches import Batch
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
    columns = columns_of(islice(rows.batches(_FIRST), 1))
    if not _write(rows.batches(), columns, path):  # a later run has more
        _write(rows.batches(), columns_of(rows.batches()), path)
    return path


def columns_of(batches: Iterable[Batch]) -> _Columns:
    """Return the parameters that vary, and the measurements, each in the order of their first occurrence."""
    parameters: dict[str, None] = {}
    measurements: dict[str, None] = {}
    for batch in batches:
        parameters.update(dict.fromkeys(chain.from_iterable(batch.column("values"))))
        measurements.update(dict.fromkeys(chain.from_iterable(batch.column("measured"))))
    return tuple(parameters), tuple(measurements)


def _write(batches: Iterable[Batch], columns: _Columns, path: Path) -> bool:
    """Write a table with these columns; returns False at the first run that has others."""
    known = [set(each) for each in columns]
    with path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        writer = csv.writer(file)
        writer.writerow(header(*columns))
        for batch in batches:
            found = columns_of([batch])
            if any(not names.issuperset(each) for names, each in zip(known, found, strict=True)):
                return False
            writer.writerows(lines_of(batch, *columns))
    return True


def header(parameters: Sequence[str], measurements: Sequence[str]) -> list[str]:
    """Return the names of all columns; see `columns_of`."""
    return [*BEFORE, *parameters, *AFTER, *measurements]


def lines_of(batch: Batch, parameters: Sequence[str], measurements: Sequence[str]) -> Iterator[tuple[Any, ...]]:
    """Yield the lines of runs; None for missing values."""
    values, measured = batch.column("values"), batch.column("measured")
    return zip(
        *map(batch.column, BEFORE),
        *([each.get(path) for each in values] for path in parameters),
        *map(batch.column, AFTER),
        *([each.get(name) for each in measured] for name in measurements),
        strict=True,
    )
