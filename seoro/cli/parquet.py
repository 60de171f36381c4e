"""`--parquet`: the tables of a run as Parquet, beside CSV."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from seoro.cli.arguments import Container, add_option
from seoro.errors import UsageError


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
    from seoro.embed.parquet import is_parquet_installed  # noqa: PLC0415 - for this option only

    if not is_parquet_installed():
        print(
            "note: `--parquet` needs pyarrow, so trajectories are written as CSV only: "
            "`pip install 'seoro[parquet]'`",
            file=sys.stderr,
        )


def as_parquet(
    path: Path, table: bytes, description: str, write: Callable[[Path, bytes], object]
) -> list[tuple[Path, str]]:
    """Write a file of the simulator as Parquet beside it, if it is a table.

    Args:
        path: The file.
        table: Its content.
        description: Description of the file.
        write: Writes a file.

    Returns:
        The written file with its description, if any.
    """
    from seoro.embed.parquet import is_parquet_installed, is_table, to_parquet  # noqa: PLC0415 - as above

    if not is_table(path.name) or not is_parquet_installed():
        return []
    file = path.with_suffix(".parquet")
    write(file, to_parquet(table))
    return [(file, f"{description}, as Parquet")]
