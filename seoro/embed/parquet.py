"""Tables of runs as Parquet, with the extra `seoro[parquet]`."""

from __future__ import annotations

from importlib.util import find_spec
from io import BytesIO

from seoro.runtime.execution.outputs import TABLES

_TEXTS = ("entity", "robot", "joint")  # columns of text
_FLAGS = ("contact",)


def is_parquet_installed() -> bool:
    """Return whether Parquet can be written."""
    return find_spec("pyarrow") is not None


def is_table(name: str) -> bool:
    """Return whether an output file of a run is a table."""
    stem, _, suffix = name.rpartition(".")
    return suffix == "csv" and stem in TABLES


def to_parquet(table: bytes) -> bytes:
    """Convert a table of a run from CSV: columns of text, of flags, and of numbers, null without a value."""
    import pyarrow  # noqa: PLC0415 - slow to load, and an extra
    from pyarrow import csv, parquet  # noqa: PLC0415 - the same

    types = {
        name: pyarrow.string() if name in _TEXTS else pyarrow.int8() if name in _FLAGS else pyarrow.float64()
        for name in table.split(b"\n", 1)[0].decode().split(",")
    }
    read = csv.read_csv(BytesIO(table), convert_options=csv.ConvertOptions(column_types=types))
    written = BytesIO()
    parquet.write_table(read, written)
    return written.getvalue()
