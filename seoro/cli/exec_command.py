"""`seoro exec`: run a scenario in this process or on an executor."""

from __future__ import annotations

import argparse

from seoro.cli.arguments import add_option
from seoro.cli.remote_arguments import add_on_arguments, check_on, use_project
from seoro.cli.results import add_result_arguments
from seoro.cli.run_arguments import add_lease_arguments, add_run_arguments
from seoro.cli.video_arguments import add_video_arguments

EXAMPLES = """examples:
  seoro exec hello.osc
  seoro exec obstacle.osc --sim mujoco --rate max -o out/
  seoro exec obstacle.osc --connect tcp/127.0.0.1:7450 --seed 7
  seoro exec check_robot.osc --ros tcp/192.168.0.7:7447
  seoro exec obstacle.osc --lab hall.yaml
  seoro exec obstacle.osc --sim mujoco --on lab-a -o out/

exit status: 0 passed, 1 failed, 2 the command line or the scenario is invalid, 3 error without a verdict,
4 cancelled (130 by Ctrl-C)"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", help="scenario file (.osc); - for stdin")
    parser.set_defaults(recorded=None, external=())
    add_local_arguments(parser)
    add_on_arguments(parser)


def add_local_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of a run in this process."""
    add_run_arguments(parser)
    add_result_arguments(parser)
    add_video_arguments(parser)
    add_option(
        parser, "-n --dry-run", "check the scenario and print the chosen values; do not run, write no files"
    )
    add_lease_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command; local and remote runs import different modules."""
    use_project(options)
    check_on(options)
    if options.on is None:
        from seoro.cli.exec_local import run_local  # noqa: PLC0415

        return run_local(options)
    from seoro.cli.exec_remote import run_remote  # noqa: PLC0415

    return run_remote(options)
