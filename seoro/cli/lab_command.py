"""`seoro lab`: show, lease, release and stop the robots of a lab."""

from __future__ import annotations

import argparse
import math
import os
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio

from seoro.cli.arguments import Container, add_command, add_keys_argument, add_option, duration
from seoro.cli.confirmation import confirm
from seoro.cli.exit_status import Exit
from seoro.cli.lab_table import lab_table, plain
from seoro.errors import UsageError
from seoro.runtime.trace.jsonl import to_json
from seoro.text.printable import one_line

if TYPE_CHECKING:
    from seoro.client.lab import LabControl
    from seoro.lab.outcomes import Outcome
    from seoro.lab.reading import Lab

EXAMPLES = """examples:
  seoro lab status --lab hall.yaml
  seoro lab status --connect tcp/192.168.0.5:7447 --watch
  seoro lab lease tb1 --for 30min --purpose "new wheels"
  seoro lab release tb1
  seoro lab stop tb1
  seoro lab release --all --reason "false alarm"
  seoro lab release --estop tb1 --reason "area is clear"

The lab consists of the nodes in the lab file (`--lab`, default SEORO_LAB) and at the endpoints (`--connect`).
Without both, it is everything on this machine.

exit status: 0 done, 2 the command line is invalid, 3 a node was not reached, or did not confirm"""
VARIABLE: Final = "SEORO_LAB"  # of the environment, with the lab file
LOCAL: Final = ("tcp/127.0.0.1:7450", "tcp/127.0.0.1:7460", "tcp/127.0.0.1:7470")
PERIOD: Final = 1.0  # [s] of `--watch`
CLEAR: Final = "\x1b[H\x1b[2J"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    commands = parser.add_subparsers(title="subcommands", dest="what", metavar="SUBCOMMAND", required=True)
    status = add_command(commands, "status", "show the state and the users of the robots")
    add_option(status, "--json", "print all details as one JSON object")
    add_option(status, "--watch", "refresh every second until Ctrl-C")
    lease = add_command(commands, "lease", "reserve robots for a time")
    lease.add_argument(
        "robots", nargs="+", metavar="ROBOT", help="names of robots, in the lab file or at their nodes"
    )
    add_option(
        lease,
        "--for TIME",
        "duration, such as 30min (default: 10min)",
        dest="duration",
        type=duration,
        default=600.0,
    )
    add_option(lease, "--purpose TEXT", "purpose, shown to other users", default="")
    release = add_command(commands, "release", "release leases or an emergency stop")
    release.add_argument("robots", nargs="*", metavar="ROBOT", help="robots, or id of a lease")
    add_option(release, "--all", "release all emergency stops")
    add_option(release, "--estop", "release the emergency stop of the named robots")
    add_option(release, "--reason TEXT", "with --all or --estop: why the release is safe")
    add_option(release, "-y --yes", "with --all or --estop: do not ask for confirmation")
    stop = add_command(commands, "stop", "stop robots once (see `seoro estop` for the emergency stop)")
    stop.add_argument("robots", nargs="+", metavar="ROBOT", help="robots to stop")
    for each in (lease, release, stop):
        add_json_argument(each)
    for each in (status, lease, release, stop):
        add_lab_arguments(each)
        add_keys_argument(each)


def add_json_argument(parser: Container) -> None:
    """Declare `--json` of a request."""
    add_option(parser, "--json", "print the outcomes as one JSON object")


def add_lab_arguments(parser: Container) -> None:
    """Declare the options that select the lab."""
    add_option(parser, "--lab FILE.yaml", f"lab file (default: {VARIABLE})", type=Path)
    add_option(
        parser,
        "--connect ENDPOINT",
        "Zenoh endpoint of a node, executor or router, in addition to the lab file",
        repeatable=True,
    )


async def run(options: argparse.Namespace) -> int:
    """Run the command."""
    return await {"status": _status, "lease": _lease, "release": _release, "stop": _stop}[options.what](options)


def lab_of(options: argparse.Namespace) -> Lab | None:
    """Read the lab file given by the options or the environment, if any."""
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file

    path = options.lab or (Path(os.environ[VARIABLE]) if os.environ.get(VARIABLE) else None)
    return None if path is None else read_lab(path)


def endpoints_of(options: argparse.Namespace, *more: str) -> tuple[str, ...]:
    """Return the endpoints of the lab; by default, those of this machine."""
    lab = lab_of(options)
    named = lab.endpoints if lab is not None else ()
    return tuple(dict.fromkeys((*named, *options.connect, *more, *default_endpoints(options))))


def default_endpoints(options: argparse.Namespace) -> tuple[str, ...]:
    """Return the default endpoints, which need not be in use; empty if the options select a lab."""
    is_named = options.lab is not None or options.connect or os.environ.get(VARIABLE)
    return () if is_named else LOCAL


async def _status(options: argparse.Namespace) -> int:
    from seoro.lab.recorded import recorded_robots  # noqa: PLC0415 - for this command only
    from seoro.lab.status import connect_members, listed_robots, refresh  # noqa: PLC0415 - Zenoh, for this command only

    endpoints, lab, quiet = endpoints_of(options), lab_of(options), default_endpoints(options)
    known, recorded = [] if lab is None else listed_robots(lab), recorded_robots(lab)
    while options.watch:
        async with connect_members(endpoints) as reached:
            while True:
                members = list((await refresh(reached)).values())
                shown = lab_table(members, known, recorded, quiet=quiet)
                print(f"{CLEAR}{time.strftime('%X')}\n{shown}", flush=True)
                await anyio.sleep(PERIOD)
                if any(not each.node or each.problem for each in members):
                    break  # reconnect: missing nodes may have started
    members = await _control(options).status()
    as_text = not options.json
    print(lab_table(members, known, recorded, quiet=quiet) if as_text else to_json(plain(members, recorded)))
    problems = [each.problem for each in members if each.display_name not in quiet]
    problems += [each.problem for each in recorded]
    return Exit.ERROR if any(problems) else Exit.PASSED


async def _lease(options: argparse.Namespace) -> int:
    found = await _control(options).lease(*options.robots, duration=options.duration, purpose=options.purpose)
    if options.json:
        print(to_json(asdict(found)))
        return Exit.PASSED
    until = time.strftime("%d %b %H:%M:%S", time.localtime(found.until))
    print(one_line(f"leased until {until}: {', '.join(found.robots)}"))
    print(f"use them with `seoro exec --lease {found.name}`; release them with `seoro lab release {found.name}`")
    return Exit.PASSED


async def _release(options: argparse.Namespace) -> int:
    if options.all or options.estop:
        return await _release_stop(options)
    if options.reason is not None or options.yes:
        raise UsageError(
            "`--reason` and `--yes` are for emergency stops",
            help="add `--estop` and robots, or `--all`",
        )
    if not options.robots:
        raise UsageError("expected robots, a lease or `--all`", help="`seoro lab status` lists robots and leases")
    return _print_outcomes(options, [await _control(options).release(name) for name in options.robots])


async def _release_stop(options: argparse.Namespace) -> int:
    if options.all and (options.robots or options.estop):
        raise UsageError(
            "`--all` cannot be combined with robots or `--estop`",
            help="use `--all` alone, or `--estop` with robots",
        )
    if options.estop and not options.robots:
        raise UsageError("expected robots after `--estop`", help="name robots, or use `--all`")
    reason = options.reason or ""
    if reason.strip() and not options.yes:  # a missing reason is refused below
        _confirm(options.robots)
    control = _control(options)
    if options.all:
        return _print_outcomes(options, await control.release_all(reason), quiet=default_endpoints(options))
    return _print_outcomes(options, await control.release_estop(*options.robots, reason=reason))


async def _stop(options: argparse.Namespace) -> int:
    return _print_outcomes(options, await _control(options).stop(*options.robots))


async def emergency_stop(options: argparse.Namespace, *more: str) -> int:
    """Trigger an emergency stop; for `seoro estop`.

    Args:
        options: Options of the command line, with `robots` and `reason`.
        more: Endpoints in addition to those of the lab.
    """
    control = _control(options, *more)
    stopped = (
        await control.estop(*options.robots, reason=options.reason)
        if options.robots
        else await control.stop_all(options.reason)
    )
    return _print_outcomes(options, stopped, quiet=default_endpoints(options))


def _confirm(robots: Sequence[str]) -> None:
    """Ask for confirmation before an emergency stop of some or all robots is released.

    Raises:
        UsageError: Stdin is not a terminal, or the answer is not yes.
    """
    names = ", ".join(robots) or "Robots"
    confirm(
        f"{names} may move as soon as the emergency stop is released. Release it?",
        needed_by="releasing an emergency stop",
        otherwise="the emergency stop was not released",
    )


def _control(options: argparse.Namespace, *more: str) -> LabControl:
    """Make the control of the selected lab, with more endpoints."""
    from seoro.client.lab import LabControl  # noqa: PLC0415 - Zenoh, for this command only

    return LabControl(endpoints_of(options, *more), lab_of(options))


def _print_outcomes(
    options: argparse.Namespace, outcomes: Sequence[Outcome], *, quiet: Sequence[str] = ()
) -> Exit:
    """Print outcomes, except those of optional endpoints (`quiet`) that were not reached."""
    shown = [each for each in outcomes if each.display_name not in quiet]
    is_reached = any(each.is_reached for each in outcomes)
    failed = not is_reached or any(each.error for each in shown)
    if options.json:
        print(to_json({"outcomes": [_plain(each) for each in shown]}))
        return Exit.ERROR if failed else Exit.PASSED
    for each in shown:
        took = f" ({each.elapsed * 1000:.0f} ms)" if math.isfinite(each.elapsed) else ""
        line = one_line(f"{each.display_name}: {each.error or each.done}{took}")
        print(f"{'FAILED ' if each.error else 'ok     '}{line}")
    if not is_reached:
        print("FAILED no node was reached; select the lab with `--lab` or `--connect`")
    return Exit.ERROR if failed else Exit.PASSED


def _plain(outcome: Outcome) -> dict[str, object]:
    """Return an outcome as JSON data, with null for an unknown time."""
    elapsed = outcome.elapsed if math.isfinite(outcome.elapsed) else None
    return {**asdict(outcome), "elapsed": elapsed}
