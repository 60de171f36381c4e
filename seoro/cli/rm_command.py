"""`seoro rm`: delete a run and its files."""

from __future__ import annotations

import argparse

import anyio

from seoro.cli.exit_status import Exit
from seoro.cli.remote_arguments import add_run_argument, named_run

EXAMPLES = """examples:
  seoro rm 3f9a

Deletes the run on its executor, with its trace and output files. Stop a running run first (`seoro stop`)."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    anyio.run(_remove, options)
    return Exit.PASSED


async def _remove(options: argparse.Namespace) -> None:
    async with named_run(options) as found:
        await found.remove()
        print(f"deleted run {found.id[:8]}")
