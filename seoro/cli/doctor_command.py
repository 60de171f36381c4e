"""`seoro doctor`: say what is installed and reachable, and what to do about what is not."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable

import anyio

from seoro.bridges.executor.addresses import ENDPOINT
from seoro.cli.exits import Exit
from seoro.cli.lab_command import LOCAL, add_lab_arguments, endpoints_of, guessed, lab_of
from seoro.cli.remote_arguments import add_executor_argument
from seoro.doctor.findings import Finding, Health
from seoro.doctor.installed import look_here
from seoro.errors import InvalidUse
from seoro.runtime.jsonl import to_json
from seoro.terminal_text import one_line

EXAMPLES = """examples:
  seoro doctor
  seoro doctor --on lab-a --lab hall.yaml
  seoro doctor --connect tcp/192.168.0.5:7447
  seoro doctor --executor tls/lab.example.org:7470 --json

exit status: 0 if nothing has failed, warnings or not; 1 if something has"""
VARIABLE = "SEORO_EXECUTOR"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--on", metavar="EXECUTOR", help="check the way to this executor (default: to all)")
    add_executor_argument(parser)
    add_lab_arguments(parser)
    parser.add_argument(
        "--json", action="store_true", help="print a JSON list instead, with an object for each line"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    found: list[Finding] = []

    def tell(finding: Finding) -> None:
        found.append(finding)
        if not options.json:
            text = one_line(f"{finding.what}: {finding.text}")
            print(f"{finding.health.value:8} {text}", flush=True)
            if finding.help:
                print(f"{'':8} = help: {one_line(finding.help)}", flush=True)

    for finding in look_here():
        tell(finding)
    anyio.run(_look_along, options, tell)
    if options.json:
        print(to_json([_plain(each) for each in found]))
    else:
        print(_summary(found))
    return Exit.FAILED if any(each.health is Health.FAILED for each in found) else Exit.PASSED


async def _look_along(options: argparse.Namespace, tell: Callable[[Finding], None]) -> None:
    from seoro.doctor.lab import Places, look_at_lab  # noqa: PLC0415 - Zenoh; what is installed is told even without
    from seoro.doctor.path import look_along  # noqa: PLC0415 - the same

    chosen = options.executor or os.environ.get(VARIABLE)
    is_asked = chosen is not None or options.on is not None
    endpoint = chosen or ENDPOINT
    if not is_asked and not await _listens(endpoint):
        tell(Finding("executor", Health.OK, f"none listens at {endpoint}, and none was asked for"))
        endpoint = ""
    try:
        lab, named = lab_of(options), endpoints_of(options)
    except InvalidUse as error:
        tell(Finding("lab file", Health.FAILED, str(error), error.help or "correct it"))
        lab, named = None, tuple(options.connect)
    if guessed(options):
        named = tuple([each for each in LOCAL if each != ENDPOINT and await _listens(each)])
    places = Places(named, lab)
    if endpoint:
        async for finding in look_along(endpoint, options.on, options.keys, places):
            tell(finding)
    async for finding in look_at_lab(places, options.keys, endpoint, is_needed=not is_asked):
        tell(finding)


async def _listens(endpoint: str) -> bool:
    from seoro.doctor.endpoint import look_at_endpoint  # noqa: PLC0415 - as above

    return (await look_at_endpoint(endpoint)).health is Health.OK


def _plain(finding: Finding) -> dict[str, str]:
    return {
        "what": finding.what,
        "status": finding.health.value,
        "message": finding.text,
        "help": finding.help,
    }


def _summary(found: Iterable[Finding]) -> str:
    health = [each.health for each in found]
    wrong, doubtful = health.count(Health.FAILED), health.count(Health.WARNING)
    return f"{wrong} failed, {doubtful} warning{'s' if doubtful != 1 else ''}, {health.count(Health.OK)} ok"
