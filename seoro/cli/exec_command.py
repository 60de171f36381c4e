"""`seoro exec`: run a scenario here, or on an executor across the network."""

from __future__ import annotations

import argparse

from seoro.cli.film_arguments import add_film_arguments
from seoro.cli.lease_arguments import add_lease_arguments
from seoro.cli.remote_arguments import add_on_arguments, check_on
from seoro.cli.results import add_result_arguments
from seoro.cli.run_arguments import add_run_arguments

EXAMPLES = """examples:
  seoro exec hello.osc
  seoro exec obstacle.osc --sim mujoco --rate max -o out/
  seoro exec obstacle.osc --connect tcp/127.0.0.1:7450 --seed 7
  seoro exec check_robot.osc --ros tcp/192.168.0.7:7447
  seoro exec obstacle.osc --lab hall.yaml
  seoro exec obstacle.osc --sim mujoco --on lab-a -o out/

exit status: 0 passed, 1 failed, 2 the command line or the scenario is invalid, 3 no verdict could be
reached, 4 cancelled (130 by Ctrl-C)"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", help="the scenario file (.osc); - for stdin")
    add_run_arguments(parser)
    add_result_arguments(parser)
    add_film_arguments(parser)
    parser.add_argument(
        "-n",
        "--dry-run",
        action="store_true",
        help="check and print the chosen values; do not run, and write no files",
    )
    add_lease_arguments(parser)
    add_on_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command, and load what that takes: a run elsewhere needs nothing of what runs one here."""
    check_on(options)
    if options.on is None:
        from seoro.cli.exec_local import run_local  # noqa: PLC0415

        return run_local(options)
    from seoro.cli.exec_remote import run_remote  # noqa: PLC0415

    return run_remote(options)
