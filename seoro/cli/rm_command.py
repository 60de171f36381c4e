"""`seoro rm`: delete a run and its files."""

from __future__ import annotations

import argparse

from seoro.cli.remote_arguments import add_run_argument, named_run

EXAMPLES = """examples:
  seoro rm 3f9a

Deletes the run on its executor, with its trace and output files. Stop a running run first (`seoro stop`)."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser)


async def run(options: argparse.Namespace) -> None:
    """Run the command."""
    async with named_run(options) as found:
        await found.remove()
        print(f"deleted run {found.id[:8]}")
