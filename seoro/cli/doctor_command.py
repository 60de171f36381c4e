"""`seoro doctor`: check the installation and the network, and suggest fixes."""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Callable

import anyio

from seoro.bridges.addresses import EXECUTOR
from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import count
from seoro.cli.lab_command import LOCAL, add_lab_arguments, default_endpoints, endpoints_of, lab_of
from seoro.cli.remote_arguments import add_executor_argument
from seoro.doctor.findings import Finding, Health
from seoro.doctor.installation import check_installation
from seoro.errors import UsageError
from seoro.runtime.trace.jsonl import to_json
from seoro.text.printable import one_line

EXAMPLES = """examples:
  seoro doctor
  seoro doctor --on lab-a --lab hall.yaml
  seoro doctor --connect tcp/192.168.0.5:7447
  seoro doctor --executor tls/lab.example.org:7470 --json

exit status: 0 without failed checks (warnings are allowed), 1 with failed checks"""
VARIABLE = "SEORO_EXECUTOR"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(parser, "--on EXECUTOR", "check the path to this executor (default: all)")
    add_executor_argument(parser)
    add_lab_arguments(parser)
    add_option(parser, "--json", "print a JSON list with one object per check")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    found: list[Finding] = []

    def report(finding: Finding) -> None:
        found.append(finding)
        if not options.json:
            text = one_line(f"{finding.what}: {finding.text}")
            print(f"{finding.health.value:8} {text}", flush=True)
            if finding.help:
                print(f"{'':8} = help: {one_line(finding.help)}", flush=True)

    for finding in check_installation():
        report(finding)
    anyio.run(_check_network, options, report)
    if options.json:
        print(to_json([_plain(each) for each in found]))
    else:
        health = Counter(each.health for each in found)
        warnings = count(health[Health.WARNING], "warning")
        print(f"{health[Health.FAILED]} failed, {warnings}, {health[Health.OK]} ok")
    return Exit.FAILED if any(each.health is Health.FAILED for each in found) else Exit.PASSED


async def _check_network(options: argparse.Namespace, report: Callable[[Finding], None]) -> None:
    from seoro.doctor.lab import Places, check_lab  # noqa: PLC0415 - Zenoh, which may be missing
    from seoro.doctor.path import check_path_to_executors  # noqa: PLC0415 - the same

    chosen = options.executor or os.environ.get(VARIABLE)
    is_asked = chosen is not None or options.on is not None
    endpoint = chosen or EXECUTOR
    if not is_asked and not await _listens(endpoint):
        report(Finding("executor", Health.OK, f"no executor at {endpoint} (none was requested)"))
        endpoint = ""
    try:
        lab, named = lab_of(options), endpoints_of(options)
    except UsageError as error:
        report(Finding("lab file", Health.FAILED, str(error), error.help or "correct it"))
        lab, named = None, tuple(options.connect)
    if default_endpoints(options):
        named = tuple([each for each in LOCAL if each != EXECUTOR and await _listens(each)])
    places = Places(named, lab)
    if endpoint:
        async for finding in check_path_to_executors(endpoint, options.on, options.keys, places):
            report(finding)
    async for finding in check_lab(places, options.keys, endpoint, is_needed=not is_asked):
        report(finding)


async def _listens(endpoint: str) -> bool:
    from seoro.doctor.endpoint import check_endpoint  # noqa: PLC0415 - as above

    return (await check_endpoint(endpoint)).health is Health.OK


def _plain(finding: Finding) -> dict[str, str]:
    return {
        "what": finding.what,
        "status": finding.health.value,
        "message": finding.text,
        "help": finding.help,
    }
