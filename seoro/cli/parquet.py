"""`--parquet`: the tables of a run as Parquet, beside CSV."""

from __future__ import annotations

import argparse
import sys
from importlib.util import find_spec
from io import BytesIO

from seoro.cli.arguments import Container, add_option
from seoro.errors import UsageError
from seoro.runtime.execution.outputs import TABLES

_TEXTS = ("entity", "robot", "joint")  # columns of text
_FLAGS = ("contact",)


def add_parquet_argument(parser: Container) -> None:
    """Declare the option."""
    add_option(parser, "--parquet", "also write the trajectories as Parquet (extra `parquet`)")


def check_parquet(options: argparse.Namespace) -> None:
    """Check before a run whether Parquet can be written; print a note if pyarrow is missing.

    Raises:
        UsageError: The output folder is missing in the options.
    """
    if not options.parquet:
        return
    if options.output_dir is None:
        raise UsageError("`--parquet` needs an output folder", help="add `-o DIR`")
    if not _is_installed():
        print(
            "note: `--parquet` needs pyarrow, so trajectories are written as CSV only: "
            "`pip install 'seoro[parquet]'`",
            file=sys.stderr,
        )


def is_table(options: argparse.Namespace, name: str) -> bool:
    """Return whether an output file is also written as Parquet."""
    stem, _, suffix = name.rpartition(".")
    return bool(options.parquet) and suffix == "csv" and stem in TABLES and _is_installed()


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


def _is_installed() -> bool:
    return find_spec("pyarrow") is not None
