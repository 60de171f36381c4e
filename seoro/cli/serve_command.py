"""`seoro serve`: run an executor, which accepts scenarios over the network and runs them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Awaitable, Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

import anyio
from anyio.abc import TaskGroup

from seoro.bridges.addresses import EXECUTOR
from seoro.cli.arguments import add_keys_argument, add_option, number
from seoro.cli.event_loop import fast_loop
from seoro.cli.exit_status import Exit
from seoro.cli.files import state_folder
from seoro.cli.parent import add_parent_argument, use_parent
from seoro.cli.serving import check_name, endpoint_errors, place_of
from seoro.cli.signals import termination_signals
from seoro.concurrency.background import background
from seoro.errors import UsageError
from seoro.files.executor_links import linked
from seoro.text.logs import log_to_stderr

if TYPE_CHECKING:
    from seoro.executor.service import ExecutorOptions

EXAMPLES = """examples:
  seoro serve --name lab-a
  seoro exec obstacle.osc --sim mujoco --on lab-a      (in another terminal)
  seoro serve --name lab-a --jobs 4 --allow python
  seoro serve --keys lab-a.keys --listen tls/0.0.0.0:7470

Ctrl-C ends the executor. Active runs are stopped and clean up; queued runs are kept for the next start."""
KEEP = 30.0  # [days]
_days = number("a positive number of days", float, lambda days: 0.0 < days < math.inf)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(parser, "--name NAME", "name of the executor, for `--on` (default: that of its keys, else local)")
    place = parser.add_mutually_exclusive_group()
    add_option(place, "--listen ENDPOINT", f"Zenoh endpoint to listen on (default: {EXECUTOR})")
    add_option(place, "--connect ENDPOINT", "connect to the executor or Zenoh router at this endpoint instead")
    add_option(parser, "--folder DIR", "folder for runs (default: ~/.local/state/seoro/NAME)")
    add_option(parser, "--jobs N", "number of simultaneous runs (default: %(default)s)", default=1)
    add_option(
        parser,
        "--keep DAYS",
        f"delete finished runs after this time (default: {KEEP:g})",
        type=_days,
        default=KEEP,
    )
    add_option(
        parser,
        "--allow NAME",
        "allow scenarios to use python, files, network, run_process, ros_run or ros_launch",
        repeatable=True,
    )
    add_option(parser, "--policy FILE", "YAML file with permissions and limits per role")
    add_option(
        parser,
        "--notify URL",
        "send the end of each run to this URL as JSON; SEORO_NOTIFY_SECRET signs",
        repeatable=True,
    )
    add_parent_argument(parser, "executors")
    add_keys_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from seoro.executor.limits import Policy, read_policy  # noqa: PLC0415 - Zenoh, for this command only
    from seoro.executor.service import ExecutorOptions  # noqa: PLC0415 - the same
    from seoro.notifications.addresses import read_address  # noqa: PLC0415 - the same

    listen = None if options.connect else options.listen or EXECUTOR
    name = options.name or _name_in_keys(options.connect or options.listen or EXECUTOR) or "local"
    check_name(name, "an executor")
    settings = ExecutorOptions(
        name,
        options.folder or state_folder() / name,
        listen,
        options.connect,
        options.jobs,
        options.keep,
        frozenset(options.allow),
        policy=read_policy(options.policy) if options.policy else Policy(),
        notify=tuple(map(read_address, options.notify)),
    )
    log_to_stderr("%(message)s")
    use_parent(options)
    with endpoint_errors():
        return anyio.run(_serve, settings, backend_options={"loop_factory": fast_loop()})


async def _serve(settings: ExecutorOptions) -> int:
    from seoro.executor.service import open_executor  # noqa: PLC0415 - as above

    with ExitStack() as links, anyio.open_signal_receiver(*termination_signals()) as signals:
        async with open_executor(settings) as started:
            links.enter_context(linked(settings.folder, state_folder()))
            where = place_of(settings.listen, settings.connect)
            print(f"executor '{settings.name}' {where}; Ctrl-C ends it", flush=True)
            if started.no_sandbox:
                print(f"runs are not sandboxed: {started.no_sandbox}", flush=True)
            if started.lost:
                print(f"{started.lost} runs were active when the executor died, and are lost", flush=True)
            async with background() as tasks:
                tasks.start_soon(_cancel_on, started.name_lost.wait, tasks)
                async for _ in signals:
                    break
            print("stopping active runs and cleaning up", flush=True)
    if started.name_lost.is_set():
        raise UsageError(
            started.why_name_lost,
            help=f"choose another `--name`; `--folder {settings.folder}` keeps its runs",
        )
    return Exit.PASSED


async def _cancel_on(wait: Callable[[], Awaitable[object]], tasks: TaskGroup) -> None:
    await wait()
    tasks.cancel_scope.cancel()


def _name_in_keys(endpoint: str) -> str | None:
    """Return the name in the keys for an endpoint; None if it needs no keys."""
    from seoro.security.network.endpoint_keys import SERVING_RUNS, keys_for  # noqa: PLC0415 - Zenoh, for this command only

    keys = keys_for(endpoint, SERVING_RUNS)
    return None if keys is None else keys.identity.name
