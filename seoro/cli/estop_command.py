"""`seoro estop`: emergency stop of all or some robots of a lab."""

from __future__ import annotations

import argparse
import os

from seoro.cli.arguments import add_keys_argument, add_option
from seoro.cli.lab_command import add_json_argument, add_lab_arguments, emergency_stop

EXAMPLES = """examples:
  seoro estop
  seoro estop --reason smoke
  seoro estop tb1 tb2
  seoro lab release --estop tb1 --reason "area is clear"
  seoro lab release --all --reason "checked by hand"

The stop takes effect at once, without confirmation. Stopped bridges, simulators and executors refuse every
command until `seoro lab release --all`. With ROBOT, only these robots stop, until `seoro lab release --estop
ROBOT`. Runs that hold one of them end; other robots are not affected. The lab consists of the nodes in the lab
file (`--lab`, default SEORO_LAB) and at the endpoints (`--connect`). Without both, it is everything on this
machine.

exit status: 0 all robots stand still, 2 the command line is invalid, 3 a node was not reached or did not
confirm"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "robots",
        nargs="*",
        metavar="ROBOT",
        help="robots to stop, by their names in the lab file or at their nodes (default: all)",
    )
    add_option(parser, "--reason TEXT", "reason, shown to all users of the lab", default="")
    add_json_argument(parser)
    add_lab_arguments(parser)
    add_option(
        parser, "--executor ENDPOINT", "Zenoh endpoint of an executor or a router (default: SEORO_EXECUTOR)"
    )
    add_keys_argument(parser)


async def run(options: argparse.Namespace) -> int:
    """Run the command."""
    executor = options.executor or os.environ.get("SEORO_EXECUTOR")
    return await emergency_stop(options, *([executor] if executor else []))
