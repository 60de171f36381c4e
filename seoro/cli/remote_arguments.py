"""Options that select executors and runs."""

from __future__ import annotations

import argparse
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.bridges.addresses import EXECUTOR
from seoro.cli.arguments import Container, add_keys_argument, add_option, given_option, integer
from seoro.cli.files import STDIN
from seoro.errors import UsageError
from seoro.lang.projects import project_of

if TYPE_CHECKING:
    from seoro.client.runs import RemoteRun


EXECUTOR_VARIABLE: Final = "SEORO_EXECUTOR"


def add_on_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `seoro exec` for remote runs."""
    group = parser.add_argument_group("remote runs")
    place = group.add_mutually_exclusive_group()
    add_option(
        place, "--on EXECUTOR", "run on this executor, started with `seoro serve` (default: that of the project)"
    )
    add_option(place, "--local", "run in this process, although the project names an executor")
    add_executor_argument(group)
    add_option(
        group,
        "--stop-if-lost SECONDS",
        "stop the run after losing this client for SECONDS (default: keep running)",
    )
    add_option(
        parser,
        "--priority N",
        "priority in the queues for robots and of the executor; higher first (default: 0)",
        type=integer,
    )


def check_on(options: argparse.Namespace) -> None:
    """Check that options for remote runs are given only with `--on`.

    Raises:
        UsageError: `--on` is missing.
    """
    if options.on is None and (given := given_option(options, "executor", "stop_if_lost")):
        raise UsageError(f"`{given}` is for runs on executors", help="add `--on NAME`")


def endpoint_of_project(options: argparse.Namespace) -> str | None:
    """Return the endpoint of executors in the settings of the project, if a command needs it, and has no other.

    Raises:
        UsageError: The settings are invalid.
    """
    if not hasattr(options, "executor") or os.environ.get(EXECUTOR_VARIABLE):
        return None
    project = project_of(Path.cwd())
    return None if project is None else project.values.get("endpoint")


def use_project(options: argparse.Namespace) -> None:
    """Fill in the executor and the output folder of a run.

    Raises:
        UsageError: The settings are invalid.
    """
    if options.file == STDIN:
        return
    file = Path(options.file)
    project = project_of(file.absolute().parent)
    if project is None:
        return
    if options.on is None and not options.local:
        options.on = project.values.get("executor")
    output = project.values.get("output")
    if options.output_dir is None and output is not None and not options.dry_run:
        options.output_dir = output / file.stem


def add_executor_argument(parser: Container) -> None:
    """Declare the options for the endpoint of executors."""
    add_option(
        parser,
        "--executor ENDPOINT",
        f"Zenoh endpoint of executors or of their router (default: SEORO_EXECUTOR, else {EXECUTOR})",
    )
    add_keys_argument(parser)


def add_run_argument(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that select a run."""
    what = "id of the run, or its first characters; `seoro ps` lists runs"
    parser.add_argument("run_id", metavar="RUN", help=what)
    add_option(parser, "--on EXECUTOR", "name of its executor (default: search all)")
    add_executor_argument(parser)


@asynccontextmanager
async def named_run(options: argparse.Namespace) -> AsyncIterator[RemoteRun]:
    """Connect to the selected run while the block lasts.

    Raises:
        UsageError: The run is unknown or ambiguous.
    """
    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for commands that need it only

    async with Client(options.executor) as client:
        yield await client.run(options.run_id, options.on)
