"""`seoro ros serve`: let nodes of a ROS 2 system start and stop runs on an executor."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager

import anyio

from seoro.bridges.ros2.participant import RosOptions, connect_system
from seoro.bridges.ros2.runs.node import serving_runs
from seoro.bridges.session import SessionError
from seoro.cli.exit_status import Exit
from seoro.cli.run_arguments import leasing_of, ros_of, settings_of
from seoro.client import Client, check_priority
from seoro.client.served_runs import ServedRuns
from seoro.concurrency.background import background
from seoro.embed.option_checks import check_options
from seoro.errors import BackendError, UsageError
from seoro.text.logs import log_to_stderr

ENDING = "the node that started it has ended"
CLEANUP = 10.0  # [s] maximum wait for the stop of runs at the end
STARTING, PAUSE = 20.0, 0.5  # [s] maximum wait for an executor that starts, and time between attempts


async def serve(options: argparse.Namespace) -> int:
    """Serve the scenario files of folders, until a signal."""
    for folder in options.folders:
        if not folder.is_dir():
            raise UsageError(f"folder of scenario files not found: {folder}")
    ros = ros_of(options)
    assert ros is not None, "has a default"
    check_priority(options.priority or 0)
    _log_runs()
    node_options = RosOptions(ros.endpoint, ros.domain, ros.dialect, ros.interfaces)
    space, _, name = options.node.strip("/").rpartition("/")
    async with _reached_executor(options) as (client, options.on), background() as tasks:
        settings = settings_of(options, leasing=leasing_of(options))
        check_options(settings)
        runs = ServedRuns(
            client,
            options.on,
            options.folders,
            settings,
            tasks,
            stop_if_lost=options.stop_if_lost,
            priority=options.priority or 0,
        )
        async with connect_system(node_options) as system, system.node(name, space) as node:
            await anyio.to_thread.run_sync(system.prepare)
            async with serving_runs(node, runs):
                served = ", ".join(map(str, options.folders))
                print(
                    f"node {node.node.full_name} at {ros.endpoint}, domain {ros.domain}: all nodes there may run "
                    f"scenarios of {served} on the executor '{options.on}'; Ctrl-C ends it",
                    flush=True,
                )
                try:
                    await anyio.sleep_forever()
                finally:
                    await _stop(runs)
    return Exit.PASSED


class _NoExecutor(UsageError):
    """The executor is missing; it may be starting."""


@asynccontextmanager
async def _reached_executor(options: argparse.Namespace) -> AsyncIterator[tuple[Client, str]]:
    """Connect to an executor, and wait for one that starts at the same time; yields its name, too.

    Raises:
        UsageError: No executor is there, or several are and the options name none.
    """
    deadline = anyio.current_time() + STARTING
    while True:
        async with AsyncExitStack() as stack:
            try:
                client = await stack.enter_async_context(Client(options.executor))
                name = chosen(client.endpoint, await client.executors(), options.on)
            except UsageError as error:
                is_starting = isinstance(error, _NoExecutor) or isinstance(error.__cause__, SessionError)
                if not is_starting or anyio.current_time() > deadline:
                    raise
            else:
                yield client, name
                return
        await anyio.sleep(PAUSE)


def chosen(endpoint: str, names: Sequence[str], wanted: str | None) -> str:
    """Return the wanted executor, or the only one.

    Raises:
        UsageError: It is missing, or ambiguous.
    """
    if not names:
        raise _NoExecutor(f"no executor at {endpoint}", help="start one with `seoro serve`")
    if wanted is None and len(names) > 1:
        raise UsageError(f"several executors at {endpoint}", help=f"add `--on` ({', '.join(names)})")
    if wanted not in (None, *names):
        raise _NoExecutor(f"no executor '{wanted}' at {endpoint}", help=f"executors there: {', '.join(names)}")
    return wanted or names[0]


async def _stop(runs: ServedRuns) -> None:
    with anyio.move_on_after(CLEANUP, shield=True):
        try:
            await runs.stop(ENDING)
        except BackendError as error:
            print(f"warning: {error}", file=sys.stderr)


def _log_runs() -> None:
    """Print starts and ends of runs, and refused requests."""
    log_to_stderr("%(message)s")
    for name in ("seoro.client.served_runs", "seoro.bridges.ros2.runs"):
        logging.getLogger(name).setLevel(logging.INFO)
