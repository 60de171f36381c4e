"""`seoro exec`: run a scenario in this process or on an executor."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, Final

from seoro.cli.arguments import add_option
from seoro.cli.files import STDIN
from seoro.cli.notifying import add_notify_argument, failure_of, notifying, use_notify
from seoro.cli.parent import add_parent_argument, use_parent
from seoro.cli.remote_arguments import add_on_arguments, check_on, use_project
from seoro.cli.results import ResultFiles, add_result_arguments
from seoro.cli.run_arguments import add_lease_arguments, add_run_arguments
from seoro.cli.video_arguments import add_video_arguments
from seoro.errors import UsageError
from seoro.lang.projects import settings_around

EXAMPLES = """examples:
  seoro exec hello.osc
  seoro exec obstacle.osc --sim mujoco --rate max -o out/
  seoro exec obstacle.osc --connect tcp/127.0.0.1:7450 --seed 7
  seoro exec check_robot.osc --ros tcp/192.168.0.7:7447
  seoro exec obstacle.osc --lab hall.yaml
  seoro exec obstacle.osc --sim mujoco --on lab-a -o out/

exit status: 0 passed, 1 failed, 2 the command line or the scenario is invalid, 3 error without a verdict,
4 cancelled (130 by Ctrl-C)"""


_NOTIFIED: Final = (
    "status", "reason", "source", "scenario", "seed", "duration", "wall_duration", "parameters", "requirements",
    "diagnostics",
)  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", help="scenario file (.osc); - for stdin")
    parser.set_defaults(recorded=None, external=())
    add_local_arguments(parser)
    add_notify_argument(parser)
    add_on_arguments(parser)
    add_parent_argument(parser, "runs")


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
    if options.die_with_parent and options.file == STDIN:
        raise UsageError("`--die-with-parent` needs stdin, which has the scenario", help="name a file")
    use_parent(options)
    use_project(options)
    check_on(options)
    use_notify(options, {} if options.file == STDIN else settings_around(Path(options.file)))
    if options.dry_run:
        options.notify = []
    files = ResultFiles(options)
    with notifying(options, "run", lambda error: _result(options, files, error)):
        if options.on is None:
            from seoro.cli.exec_local import run_local  # noqa: PLC0415

            return run_local(options, files)
        from seoro.cli.exec_remote import run_remote  # noqa: PLC0415

        return run_remote(options, files)


def _result(options: argparse.Namespace, files: ResultFiles, error: BaseException | None) -> dict[str, Any]:
    """Return the result for notifications."""
    place = {"file": options.file, "folder": options.output_dir and str(options.output_dir.absolute())}
    if files.result is None:
        return {**failure_of(error), **place}
    return {**{name: files.result[name] for name in _NOTIFIED if name in files.result}, **place}
