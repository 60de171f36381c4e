"""The table of the runs as Parquet, `runs.parquet`, with the extra `seoro[parquet]`."""

from __future__ import annotations

from pathlib import Path
from typing import Final

PARQUET: Final = "runs.parquet"
_TEXTS: Final = (
    "id", "status", "reason", "reason_key", "where", "strategy", "host", "worker", "started", "version", "folder",
    "trace_sha",
)  # fmt: skip


def write_parquet(table: Path) -> Path:
    """Convert the table of a campaign; types of parameters and measurements follow from their values.

    Args:
        table: The table, `runs.csv`.

    Returns:
        The converted table, beside it.

    Raises:
        OSError: It cannot be written.
    """
    import pyarrow  # noqa: PLC0415 - slow to load, and an extra
    from pyarrow import csv, parquet  # noqa: PLC0415 - the same

    path = table.with_name(PARQUET)
    parse = csv.ParseOptions(newlines_in_values=True)
    convert = csv.ConvertOptions(column_types=dict.fromkeys(_TEXTS, pyarrow.string()))
    try:
        with (
            csv.open_csv(table, parse_options=parse, convert_options=convert) as blocks,
            parquet.ParquetWriter(path, blocks.schema, compression="zstd") as writer,
        ):
            for block in blocks:
                writer.write_batch(block)
    except pyarrow.ArrowInvalid:  # a value of a later block is of another type than those of the first
        read = csv.read_csv(table, parse_options=parse, convert_options=convert)
        parquet.write_table(read, path, compression="zstd")
    return path
