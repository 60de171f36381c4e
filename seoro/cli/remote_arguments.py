"""Options that select executors and runs."""

from __future__ import annotations

import argparse
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from seoro.bridges.addresses import EXECUTOR
from seoro.cli.arguments import Container, add_keys_argument, add_option, given_option, integer
from seoro.errors import UsageError

if TYPE_CHECKING:
    from seoro.client.runs import RemoteRun


def add_on_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `seoro exec` for remote runs."""
    group = parser.add_argument_group("remote runs")
    add_option(group, "--on EXECUTOR", "run on this executor, started with `seoro serve`")
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
