"""`seoro stop`: stop runs on executors."""

from __future__ import annotations

import argparse

import anyio

from seoro.cli.arguments import add_option
from seoro.cli.remote_arguments import add_executor_argument
from seoro.client.runs import RemoteRun
from seoro.embed.whoami import whoami
from seoro.errors import UsageError

EXAMPLES = """examples:
  seoro stop 3f9a
  seoro stop 3f9a 81c0
  seoro stop --mine

Waits until the runs have cleaned up. Finished runs are not affected. `seoro estop` is the emergency stop, which
stops robots."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "runs", metavar="RUN", nargs="*", help="ids of runs, or their first characters; `seoro ps` lists runs"
    )
    add_option(parser, "--mine", "stop all active runs that you submitted")
    parser.add_argument("--all", action="store_true", help=argparse.SUPPRESS)
    add_option(parser, "--on EXECUTOR", "name of the executor (default: search all)")
    add_executor_argument(parser)


async def run(options: argparse.Namespace) -> None:
    """Run the command."""
    if options.all:
        raise UsageError(
            "unsupported option `--all`",
            help="`seoro estop` stops all robots, `seoro stop --mine` stops all your runs",
        )
    if options.mine == bool(options.runs):
        raise UsageError("expected either runs or `--mine`", help="`seoro ps` lists runs")
    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for commands that need it only

    async with Client(options.executor) as client:
        if options.mine:
            runs = [each for each in await client.runs(options.on) if each.info.by == whoami()]
            found = [each for each in runs if not each.state.is_final]
            if not found:
                print("you have no active runs")
        else:
            found = [await client.run(name, options.on) for name in options.runs]
        async with anyio.create_task_group() as stopping:
            for each in found:
                stopping.start_soon(_stop_one, each)


async def _stop_one(run: RemoteRun) -> None:
    if run.state.is_final:
        print(f"run {run.id[:8]} has already ended: {run.state.value}")
        return
    await run.stop("stopped by `seoro stop`")
    async for _ in run.parts():
        pass
    print(f"run {run.id[:8]}: {run.state.value}")
