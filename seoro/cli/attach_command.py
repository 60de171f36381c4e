"""`seoro attach`: follow a run on an executor from its first record to its end."""

from __future__ import annotations

import argparse
import sys

import anyio

from seoro.cli.remote_arguments import add_run_argument, named_run
from seoro.cli.results import ResultFiles, add_result_arguments

EXAMPLES = """examples:
  seoro attach 3f9a
  seoro attach 3f9a -o out/ --live-tree

Prints the same as `seoro exec --on`, with the same exit status. Ctrl-C ends this command; the run continues."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser)
    add_result_arguments(parser)
    parser.set_defaults(dry_run=False)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    files = ResultFiles(options)
    with files.open():
        return anyio.run(_attach, options, files)


async def _attach(options: argparse.Namespace, files: ResultFiles) -> int:
    from seoro.bridges.executor.clocks import describe  # noqa: PLC0415 - Zenoh, for this command only
    from seoro.cli.follower import Follower  # noqa: PLC0415 - Zenoh, for this command only

    async with named_run(options) as found:
        _, clock = await describe(found.executor)
        if clock is not None and clock.is_wrong:
            print(
                f"note: the clock of {found.executor.name} is {clock} of this machine", file=sys.stderr, flush=True
            )
        return await Follower(options, files, stops=False).follow(found)
