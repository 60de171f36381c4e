"""`seoro estop`: emergency stop of all robots of a lab, or of some."""

from __future__ import annotations

import argparse
import os

import anyio

from seoro.cli.keys_arguments import add_keys_argument
from seoro.cli.lab_command import add_lab_arguments, stop_at_once

EXAMPLES = """examples:
  seoro estop
  seoro estop --reason smoke
  seoro estop tb1 tb2
  seoro lab release --estop tb1 --reason "nobody is near"
  seoro lab release --all --reason "checked by hand"

It stops at once, without a question. Bridges, simulators and executors that are stopped refuse every command until
`seoro lab release --all`. With ROBOT, only these robots are stopped, until `seoro lab release --estop ROBOT`; runs
that hold one of them end, and all other robots go on. A lab is its lab file (`--lab`, else that of SEORO_LAB), and
what answers at endpoints (`--connect`); without either, what runs on this machine.

exit status: 0 all stand still, 2 the command line is invalid, 3 something was not reached or has not confirmed"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "robots",
        nargs="*",
        metavar="ROBOT",
        help="robots to stop, by their names in the lab file or at their nodes (default: everything)",
    )
    parser.add_argument("--reason", default="", metavar="TEXT", help="reason, shown to everybody in the lab")
    add_lab_arguments(parser)
    parser.add_argument(
        "--executor", metavar="ENDPOINT", help="endpoint of an executor or a router (default: SEORO_EXECUTOR)"
    )
    add_keys_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    executor = options.executor or os.environ.get("SEORO_EXECUTOR")
    return anyio.run(stop_at_once, options, *([executor] if executor else []))
