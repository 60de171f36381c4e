"""The options by which commands reach executors, and the run that they name."""

from __future__ import annotations

import argparse
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from seoro.bridges.executor.addresses import ENDPOINT
from seoro.cli.arguments import Container, positive
from seoro.cli.keys_arguments import add_keys_argument
from seoro.errors import InvalidUse

if TYPE_CHECKING:
    from seoro.client.runs import RemoteRun


def add_on_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare those of `seoro exec`."""
    group = parser.add_argument_group("across the network")
    group.add_argument(
        "--on", metavar="EXECUTOR", help="run it on this executor, which `seoro serve` has started, not here"
    )
    add_executor_argument(group)
    group.add_argument(
        "--stop-if-lost",
        type=positive,
        metavar="SECONDS",
        help="have the run stopped when the connection to this command is lost for so long (default: it goes on)",
    )
    parser.add_argument(
        "--priority",
        type=int,
        metavar="N",
        help="come before those that wait with a lower priority, for robots or at the executor (default: 0)",
    )


def check_on(options: argparse.Namespace) -> None:
    """Refuse options that do not go together.

    Raises:
        InvalidUse: They do not.
    """
    if options.on is None:
        remote = {"--executor": options.executor, "--stop-if-lost": options.stop_if_lost}
        for name, value in remote.items():
            if value is not None:
                raise InvalidUse(f"`{name}` is about an executor, and the run is here", help="add `--on NAME`")


def add_executor_argument(parser: Container) -> None:
    """Declare where executors are reached."""
    parser.add_argument(
        "--executor",
        metavar="ENDPOINT",
        help=f"where executors are reached (default: that of SEORO_EXECUTOR, else {ENDPOINT})",
    )
    add_keys_argument(parser)


def add_run_argument(parser: argparse.ArgumentParser) -> None:
    """Declare which run is meant, and where it is looked for."""
    what = "id of the run, or how it begins; `seoro ps` lists runs"
    parser.add_argument("run_id", metavar="RUN", help=what)
    parser.add_argument("--on", metavar="EXECUTOR", help="name of its executor (default: all are asked)")
    add_executor_argument(parser)


@asynccontextmanager
async def named_run(options: argparse.Namespace) -> AsyncIterator[RemoteRun]:
    """The run that the options name, with a connection for as long as the block lasts.

    Raises:
        InvalidUse: There is none, or several.
    """
    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for commands that need it only

    async with Client(options.executor) as client:
        yield await client.run(options.run_id, options.on)
