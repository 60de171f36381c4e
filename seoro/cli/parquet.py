"""`--parquet`: the tables of a run as Parquet, beside CSV."""

from __future__ import annotations

import argparse
import sys

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
