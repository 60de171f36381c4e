"""`seoro serve`: be an executor, which runs scenarios that come over the network."""

from __future__ import annotations

import argparse
import os
import re
import signal
from pathlib import Path
from typing import TYPE_CHECKING

import anyio

from seoro.bridges.executor.addresses import ENDPOINT
from seoro.cli.arguments import number, whole
from seoro.cli.exits import Exit
from seoro.errors import InvalidUse

if TYPE_CHECKING:
    from seoro.executor.running import ExecutorOptions

EXAMPLES = """examples:
  seoro serve --name lab-a
  seoro exec obstacle.osc --sim mujoco --on lab-a      (in another terminal)
  seoro serve --name lab-a --jobs 4 --allow python

It ends on Ctrl-C: what runs is stopped and cleans up, what waits is run when it is started again."""
KEEP = 30.0  # [days]
# Who reaches these is on this machine already.
_LOOPBACK = re.compile(r"unixsock-stream/.+|[a-z]+/(127(\.\d{1,3}){3}|localhost|\[::1\]):\d+.*")
_ENDS = (signal.SIGINT, signal.SIGTERM)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--name", default="local", help="name of the executor, for `--on` (default: %(default)s)")
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
        help="let scenarios do what they else may not: python, run_process, ros_run, ros_launch (repeatable)",
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from seoro.bridges.session import SessionError  # noqa: PLC0415 - Zenoh, for this command only
    from seoro.executor.running import ExecutorOptions  # noqa: PLC0415 - the same

    if re.fullmatch(r"[a-z0-9_-]+", options.name) is None:
        raise InvalidUse(f"'{options.name}' cannot name an executor: use lower-case letters, digits, '_' and '-'")
    listen = None if options.connect else options.listen or ENDPOINT
    _check_loopback(options.connect or ENDPOINT if listen is None else listen)
    settings = ExecutorOptions(
        options.name,
        options.folder or _state_folder() / options.name,
        listen,
        options.connect,
        options.jobs,
        options.keep,
        frozenset(options.allow),
    )
    try:
        return anyio.run(_serve, settings)
    except SessionError as error:
        raise InvalidUse(str(error), help="`--listen` or `--connect` says where clients reach it") from error


async def _serve(settings: ExecutorOptions) -> int:
    from seoro.executor.running import executing  # noqa: PLC0415 - as above

    with anyio.open_signal_receiver(*_ENDS) as signals:
        async with executing(settings) as lost:
            where = f"listens on {settings.listen}" if settings.listen else f"is connected to {settings.connect}"
            print(f"the executor '{settings.name}' {where}; Ctrl-C ends it", flush=True)
            if lost:
                print(f"{lost} of its runs went on when it died: they are lost", flush=True)
            async for _ in signals:
                print("stopping what runs, and cleaning up", flush=True)
                break
    return Exit.PASSED


def _check_loopback(endpoint: str) -> None:
    """Refuse what others could reach.

    Raises:
        InvalidUse: They could.
    """
    if _LOOPBACK.fullmatch(endpoint) is None:
        raise InvalidUse(
            f"an executor runs what it is sent, and at {endpoint} others than this machine's users could send "
            "something: there are no keys yet that would tell who may",
            help=f"use an address of this machine such as {ENDPOINT}, and reach it by a tunnel: `ssh -L`",
        )


def _state_folder() -> Path:
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "seoro"


def _days(text: str) -> float:
    return number(text, "a positive number of days", lambda value: value > 0.0)
