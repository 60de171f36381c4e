"""`seoro lab`: the robots of a lab: how they are, who has them, and stopping them."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio

from seoro.cli.arguments import Container
from seoro.cli.exits import Exit
from seoro.cli.keys_arguments import add_keys_argument
from seoro.cli.lab_table import plain, table
from seoro.errors import InvalidUse
from seoro.runtime.jsonl import to_json
from seoro.terminal_text import one_line

if TYPE_CHECKING:
    from seoro.client.lab import LabControl
    from seoro.lab.commanding import Outcome
    from seoro.lab.reading import Lab

EXAMPLES = """examples:
  seoro lab status --lab hall.yaml
  seoro lab status --connect tcp/192.168.0.5:7447 --watch
  seoro lab lease tb1 --for 30min --purpose "new wheels"
  seoro lab release tb1
  seoro lab stop tb1
  seoro lab release --all --reason "it was toast"
  seoro lab release --estop tb1 --reason "nobody is near"

A lab is its lab file (`--lab`, else that of SEORO_LAB), and all that is alive at endpoints (`--connect`); without
either, what runs on this machine.

exit status: 0 done, 2 it cannot be done, 3 somebody has not done it, or could not be asked"""
VARIABLE: Final = "SEORO_LAB"  # of the environment, with the lab file
LOCAL: Final = ("tcp/127.0.0.1:7450", "tcp/127.0.0.1:7460", "tcp/127.0.0.1:7470")
PERIOD: Final = 1.0  # [s] between two looks
CLEAR: Final = "\x1b[H\x1b[2J"
_UNITS: Final = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86_400.0}
_DURATION: Final = re.compile(r"(?P<number>\d+(\.\d+)?)\s*(?P<unit>s|min|h|d)")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    commands = parser.add_subparsers(title="what to do", dest="what", metavar="WHAT", required=True)
    status = commands.add_parser("status", help="how the robots are, and who has them")
    status.add_argument("--json", action="store_true", help="print a JSON object, with all that is known")
    status.add_argument("--watch", action="store_true", help="look again every second, until Ctrl-C")
    lease = commands.add_parser("lease", help="keep robots for yourself for a while")
    lease.add_argument(
        "robots", nargs="+", metavar="ROBOT", help="names of robots, in the lab file or at their nodes"
    )
    lease.add_argument(
        "--for",
        dest="duration",
        type=duration,
        default=600.0,
        metavar="TIME",
        help="such as 30min (default: 10min)",
    )
    lease.add_argument("--purpose", default="", metavar="TEXT", help="what for, for others who want them")
    release = commands.add_parser("release", help="end leases by hand, or an emergency stop")
    release.add_argument("robots", nargs="*", metavar="ROBOT", help="robots, or the id of a lease")
    release.add_argument("--all", action="store_true", help="release all emergency stops")
    release.add_argument("--estop", action="store_true", help="release the emergency stop of the named robots")
    release.add_argument("--reason", metavar="TEXT", help="with --all or --estop: why that is safe")
    release.add_argument(
        "-y", "--yes", action="store_true", help="with --all or --estop: do not ask for confirmation"
    )
    stop = commands.add_parser("stop", help="stop robots, which may move again afterwards (see `seoro estop`)")
    stop.add_argument("robots", nargs="+", metavar="ROBOT", help="robots to stop")
    for each in (status, lease, release, stop):
        add_lab_arguments(each)
        add_keys_argument(each)


def add_lab_arguments(parser: Container) -> None:
    """Declare where the lab is."""
    parser.add_argument(
        "--lab", type=Path, metavar="FILE.yaml", help=f"the lab file (default: that of {VARIABLE}, if it is set)"
    )
    parser.add_argument(
        "--connect",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="Zenoh endpoint of a node, an executor or a router, beside those of the lab file (repeatable)",
    )


def duration(text: str) -> float:
    """A time of the command line [s].

    Raises:
        ArgumentTypeError: It is none.
    """
    parts = _DURATION.fullmatch(text)
    if parts is None:
        raise argparse.ArgumentTypeError(f"expected a time such as 90s, 30min, 2h or 1d, not {text!r}")
    return float(parts["number"]) * _UNITS[parts["unit"]]


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    return anyio.run(
        {"status": _status, "lease": _lease, "release": _release, "stop": _stop}[options.what], options
    )


def lab_of(options: argparse.Namespace) -> Lab | None:
    """The lab file that the options name, or the environment does."""
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file

    path = options.lab or (Path(os.environ[VARIABLE]) if os.environ.get(VARIABLE) else None)
    return None if path is None else read_lab(path)


def endpoints_of(options: argparse.Namespace, *more: str) -> tuple[str, ...]:
    """Where the lab is reached that the options name; what runs on this machine if they name none."""
    lab = lab_of(options)
    named = () if lab is None else lab.endpoints
    return tuple(dict.fromkeys((*named, *options.connect, *more, *guessed(options))))


def guessed(options: argparse.Namespace) -> tuple[str, ...]:
    """Where the lab may be if nobody has said where it is; nothing has to be there."""
    is_named = options.lab is not None or options.connect or os.environ.get(VARIABLE)
    return () if is_named else LOCAL


async def _status(options: argparse.Namespace) -> int:
    from seoro.lab.seeing import asking, known_of, reaching  # noqa: PLC0415 - Zenoh, for this command only

    endpoints, lab = endpoints_of(options), lab_of(options)
    known = [] if lab is None else known_of(lab)
    while options.watch:
        async with reaching(endpoints) as reached:
            while True:
                members = await asking(reached)
                print(f"{CLEAR}{time.strftime('%X')}\n{table(members, known, quiet=guessed(options))}", flush=True)
                await anyio.sleep(PERIOD)
                if any(not each.node or each.why for each in members):
                    break  # whoever was not there may be by now
    members = await _control(options).status()
    print(to_json(plain(members)) if options.json else table(members, known, quiet=guessed(options)))
    quiet = guessed(options)
    return Exit.ERROR if any(each.why and each.called not in quiet for each in members) else Exit.PASSED


async def _lease(options: argparse.Namespace) -> int:
    found = await _control(options).lease(*options.robots, duration=options.duration, purpose=options.purpose)
    until = time.strftime("%d %b %H:%M:%S", time.localtime(found.until))
    print(one_line(f"leased until {until}: {', '.join(found.robots)}"))
    print(f"runs get them with `seoro exec --lease {found.name}`; `seoro lab release {found.name}` ends it")
    return Exit.PASSED


async def _release(options: argparse.Namespace) -> int:
    if options.all or options.estop:
        return await _release_stop(options)
    if options.reason is not None or options.yes:
        raise InvalidUse(
            "`--reason` and `--yes` belong to the release of an emergency stop",
            help="add `--estop` for the named robots, or `--all`",
        )
    if not options.robots:
        raise InvalidUse("it is not said what to release", help="name robots or a lease, or say `--all`")
    return _told([await _control(options).release(name) for name in options.robots])


async def _release_stop(options: argparse.Namespace) -> int:
    if options.all and (options.robots or options.estop):
        raise InvalidUse(
            "`--all` releases all emergency stops",
            help="leave out the robots, or use `--estop` instead of `--all`",
        )
    if options.estop and not options.robots:
        raise InvalidUse("`--estop` expects robots", help="name them, or use `--all`")
    reason = options.reason or ""
    if reason.strip() and not options.yes:  # a missing reason is refused below
        _confirm(options.robots)
    control = _control(options)
    if options.all:
        return _told(await control.release_all(reason), quiet=guessed(options))
    return _told(await control.release_estop(*options.robots, reason=reason))


async def _stop(options: argparse.Namespace) -> int:
    return _told(await _control(options).stop(*options.robots))


async def stop_at_once(options: argparse.Namespace, *more: str) -> int:
    """Stop robots in an emergency; for `seoro estop`.

    Args:
        options: Options of the command line, with `robots` and `reason`.
        more: Endpoints beside those of the lab.
    """
    control = _control(options, *more)
    if options.robots:
        stopped = await control.estop(*options.robots, reason=options.reason)
        return _told(stopped, quiet=guessed(options))
    return _told(await control.stop_all(options.reason), quiet=guessed(options))


def _confirm(robots: Sequence[str]) -> None:
    """Ask whether an emergency stop is to be released, of some robots or of all.

    Raises:
        InvalidUse: Nobody can answer, or the answer is not yes.
    """
    if not sys.stdin.isatty():
        raise InvalidUse("the release of an emergency stop needs a confirmation", help="confirm it by `--yes`")
    whose = ", ".join(robots) or "Robots"
    answer = input(f"{one_line(whose)} may move as soon as the emergency stop is released. Release it? [y/N] ")
    if answer.strip().lower() not in ("y", "yes"):
        raise InvalidUse("the emergency stop was not released")


def _control(options: argparse.Namespace, *more: str) -> LabControl:
    """The lab that the options name, and more endpoints."""
    from seoro.client.lab import LabControl  # noqa: PLC0415 - Zenoh, for this command only

    return LabControl(endpoints_of(options, *more), lab_of(options))


def _told(outcomes: Sequence[Outcome], *, quiet: Sequence[str] = ()) -> Exit:
    """Print what came of it; `quiet` about endpoints at which nobody has to live."""
    shown = [each for each in outcomes if each.called not in quiet]
    for each in shown:
        took = f" ({each.took * 1000:.0f} ms)" if math.isfinite(each.took) else ""
        line = one_line(f"{each.called}: {each.error or each.done}{took}")
        print(f"{'FAILED ' if each.error else 'ok     '}{line}")
    if not any(each.is_somebody for each in outcomes):
        print("FAILED nobody was reached: `--lab` or `--connect` says where the lab is")
        return Exit.ERROR
    return Exit.ERROR if any(each.error for each in shown) else Exit.PASSED
