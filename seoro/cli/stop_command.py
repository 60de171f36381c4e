"""`seoro stop`: stop a run on an executor, or, in an emergency, everything."""

from __future__ import annotations

import argparse
import os

import anyio

from seoro.cli.exits import Exit
from seoro.cli.lab_command import add_lab_arguments, add_stop_arguments, stop_everything
from seoro.cli.remote_arguments import add_run_argument, named_run
from seoro.errors import InvalidUse

EXAMPLES = """examples:
  seoro stop 3f9a
  seoro stop --all --reason "smoke"

It waits until the run has cleaned up. One that is over stays as it is. With `--all`, all of a lab is stopped at
once, and nothing moves until `seoro lab release --all`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser, may_be_none=True)
    add_stop_arguments(parser)
    add_lab_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.all == (options.run_id is not None):
        raise InvalidUse("it is not said what to stop", help="name a run, or say `--all`")
    if options.all:
        executor = options.executor or os.environ.get("SEORO_EXECUTOR")
        return anyio.run(stop_everything, options, *([executor] if executor else []))
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
