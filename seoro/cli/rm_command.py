"""`seoro rm`: have executors forget runs."""

from __future__ import annotations

import argparse

import anyio

from seoro.cli.exits import Exit
from seoro.cli.remote_arguments import add_run_argument

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
    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for this command only

    async with Client(options.executor) as client:
        found = await client.run(options.run_id, options.on)
        await found.remove()
        print(f"run {found.id[:8]} is removed")
