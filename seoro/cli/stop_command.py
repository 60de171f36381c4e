"""`seoro stop`: stop a run on an executor."""

from __future__ import annotations

import argparse

import anyio

from seoro.cli.exits import Exit
from seoro.cli.remote_arguments import add_run_argument, named_run

EXAMPLES = """examples:
  seoro stop 3f9a

It waits until the run has cleaned up. One that is over stays as it is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    anyio.run(_stop, options)
    return Exit.PASSED


async def _stop(options: argparse.Namespace) -> None:
    async with named_run(options) as found:
        if found.state.is_final:
            print(f"run {found.id[:8]} is over: {found.state.value}")
            return
        await found.stop("stopped by `seoro stop`")
        async for _ in found.parts():
            pass
        print(f"run {found.id[:8]}: {found.state.value}")
