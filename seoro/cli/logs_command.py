"""`seoro logs`: print the progress of a run on an executor so far."""

from __future__ import annotations

import argparse
import sys

from seoro.cli.output import Progress
from seoro.cli.remote_arguments import add_run_argument, named_run

EXAMPLES = """examples:
  seoro logs 3f9a

`seoro attach` follows a run to its end; `seoro get` downloads its trace and output files."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser)


async def run(options: argparse.Namespace) -> None:
    """Run the command."""
    progress = Progress(sys.stdout)
    async with named_run(options) as found:
        progress.print_line(f"{found.info.file}: {found.info.announcement or 'not started'}\n")
        async for record in found.records_so_far():
            progress.record(record)
    info = found.info
    progress.print_line(f"\n{info.state.value}" + (f": {info.reason}" if info.reason else ""))
    await progress.finish()
