"""`seoro serve`: be an executor, which runs scenarios that come over the network."""

from __future__ import annotations

import argparse
import re
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import anyio
from anyio.abc import TaskGroup

from seoro.background import background
from seoro.bridges.executor.addresses import ENDPOINT
from seoro.cli.arguments import number, whole
from seoro.cli.exits import Exit
from seoro.cli.files import state_folder
from seoro.cli.keys_arguments import add_keys_argument
from seoro.cli.signals import ending_signals
from seoro.errors import InvalidUse
from seoro.terminal_text import log_to_stderr

if TYPE_CHECKING:
    from seoro.executor.running import ExecutorOptions

EXAMPLES = """examples:
  seoro serve --name lab-a
  seoro exec obstacle.osc --sim mujoco --on lab-a      (in another terminal)
  seoro serve --name lab-a --jobs 4 --allow python
  seoro serve --keys lab-a.keys --listen tls/0.0.0.0:7470

It ends on Ctrl-C: what runs is stopped and cleans up, what waits is run when it is started again."""
KEEP = 30.0  # [days]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--name", help="name of the executor, for `--on` (default: that in its keys if it has any, else local)"
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument("--listen", metavar="ENDPOINT", help=f"listen there for clients (default: {ENDPOINT})")
    place.add_argument("--connect", metavar="ENDPOINT", help="be reached over the executor or Zenoh router there")
    parser.add_argument(
        "--folder",
        type=Path,
        metavar="DIR",
        help="keep runs there (default: a folder with its name in ~/.local/state/seoro)",
    )
    parser.add_argument(
        "--jobs", type=whole, default=1, metavar="N", help="run so many scenarios at a time (default: %(default)s)"
    )
    parser.add_argument(
        "--keep",
        type=_days,
        default=KEEP,
        metavar="DAYS",
        help=f"forget runs that have been over for so long (default: {KEEP:g})",
    )
    parser.add_argument(
        "--allow",
        action="append",
        default=[],
        metavar="NAME",
        help="let scenarios do what they else may not: python, files, network, run_process, ros_run, ros_launch "
        "(repeatable)",
    )
    parser.add_argument(
        "--policy", type=Path, metavar="FILE", help="what those of each role may do, and how much of it (YAML)"
    )
    add_keys_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from seoro.bridges.session import SessionError  # noqa: PLC0415 - Zenoh, for this command only
    from seoro.executor.limits import Policy, read_policy  # noqa: PLC0415 - the same
    from seoro.executor.running import ExecutorOptions  # noqa: PLC0415 - the same

    listen = None if options.connect else options.listen or ENDPOINT
    name = options.name or _name_in_keys(options.connect or options.listen or ENDPOINT) or "local"
    if re.fullmatch(r"[a-z0-9_-]+", name) is None:
        raise InvalidUse(f"'{name}' cannot name an executor: use lower-case letters, digits, '_' and '-'")
    settings = ExecutorOptions(
        name,
        options.folder or state_folder() / name,
        listen,
        options.connect,
        options.jobs,
        options.keep,
        frozenset(options.allow),
        policy=read_policy(options.policy) if options.policy else Policy(),
    )
    log_to_stderr("%(message)s")
    try:
        return anyio.run(_serve, settings, backend_options={"use_uvloop": find_spec("uvloop") is not None})
    except SessionError as error:
        raise InvalidUse(str(error), help="`--listen` or `--connect` says where clients reach it") from error


async def _serve(settings: ExecutorOptions) -> int:
    from seoro.executor.running import executing  # noqa: PLC0415 - as above

    with anyio.open_signal_receiver(*ending_signals()) as signals:
        async with executing(settings) as started:
            where = f"listens on {settings.listen}" if settings.listen else f"is connected to {settings.connect}"
            print(f"the executor '{settings.name}' {where}; Ctrl-C ends it", flush=True)
            if started.no_sandbox:
                print(f"runs are not sandboxed: {started.no_sandbox}", flush=True)
            if started.lost:
                print(f"{started.lost} of its runs went on when it died: they are lost", flush=True)
            async with background() as tasks:
                tasks.start_soon(_cancel_when, started.name_lost, tasks)
                async for _ in signals:
                    break
            print("stopping what runs, and cleaning up", flush=True)
    if started.name_lost.is_set():
        raise InvalidUse(
            started.why_name_lost,
            help=f"`--name` gives this one another; with `--folder {settings.folder}` it goes on with its runs",
        )
    return Exit.PASSED


async def _cancel_when(happened: anyio.Event, tasks: TaskGroup) -> None:
    await happened.wait()
    tasks.cancel_scope.cancel()


def _name_in_keys(endpoint: str) -> str | None:
    """Whose keys an executor would have at an endpoint; None if it would have none."""
    from seoro.bridges.secured import SERVING_RUNS, keys_for  # noqa: PLC0415 - Zenoh, for this command only

    keys = keys_for(endpoint, SERVING_RUNS)
    return None if keys is None else keys.identity.name


def _days(text: str) -> float:
    return number(text, "a positive number of days", lambda value: value > 0.0)
