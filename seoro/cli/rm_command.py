"""`seoro rm`: have executors forget runs."""

from __future__ import annotations

import argparse

import anyio

from seoro.cli.exits import Exit
from seoro.cli.remote_arguments import add_run_argument, named_run

EXAMPLES = """examples:
  seoro rm 3f9a

Its trace and all that it has left are removed with it. A run that is not over is to be stopped first."""


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
        print(f"run {found.id[:8]} is removed")
