"""`seoro ps`: list the runs and the state of executors."""

from __future__ import annotations

import argparse
import sys
import time
from typing import TYPE_CHECKING

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.remote_arguments import add_executor_argument
from seoro.cli.tables import table
from seoro.errors import BackendLost
from seoro.runtime.trace.jsonl import to_json
from seoro.text.printable import one_line

if TYPE_CHECKING:
    from seoro.bridges.executor.messages import RunInfo
    from seoro.client import ExecutorStatus
    from seoro.client.runs import RemoteRun

EXAMPLES = """examples:
  seoro ps
  seoro ps --on lab-a --json
  seoro ps --verbose

`queued #3` is the third run in the queue. The last column shows the users that a run waits for to get its robots.
Times are corrected for wrong clocks of executors."""
_TITLES = ("RUN", "EXECUTOR", "STATE", "SINCE", "TOOK", "BY", "FILE", "WAITING FOR")
_EXECUTOR_TITLES = ("EXECUTOR", "VERSION", "JOBS", "RUNNING", "QUEUED", "CLOCK", "ROUND TRIP")
PATIENCE = 2.0  # [s] for the answer of an executor
_UNITS = ((86_400, "d"), (3_600, "h"), (60, "min"))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(parser, "--on EXECUTOR", "list only the runs of this executor (default: all)")
    add_executor_argument(parser)
    add_option(parser, "--limit N", "list the N latest runs (default: %(default)s)", default=20)
    add_option(parser, "--verbose", "also list the executors with their load and clocks")
    add_option(parser, "--json", "print a JSON list with all details of each run")


async def run(options: argparse.Namespace) -> int:
    """Run the command."""
    executors, found, silent = await _query(options)
    for reason in silent:
        print(f"note: {one_line(reason)}; its runs are not listed", file=sys.stderr)
    status = Exit.ERROR if silent else Exit.PASSED
    ahead = {each.name: each.clock.offset if each.clock is not None else 0.0 for each in executors}
    if options.json:
        print(to_json([{"executor": each.executor.name, **each.info.model_dump(mode="json")} for each in found]))
        return status
    if options.verbose:
        print(table([_EXECUTOR_TITLES, *map(_executor_row, executors)]) + "\n")
    if not found:
        print("no runs")
    else:
        rows = [_row(each, time.time() + ahead[each.executor.name]) for each in found]
        if not any(each.info.waits for each in found):
            rows = [row[:-1] for row in rows]
        print(table([_TITLES[: len(rows[0])], *rows]))
    return status


async def _query(options: argparse.Namespace) -> tuple[list[ExecutorStatus], list[RemoteRun], list[str]]:
    """Return the states of executors, their runs, and errors of executors that did not answer."""
    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for this command only

    statuses: list[ExecutorStatus] = []
    runs: list[RemoteRun] = []
    silent: list[str] = []
    limit = min(options.limit, 1000)
    async with Client(options.executor, patience=PATIENCE) as client:
        for name in [options.on] if options.on else await client.executors():
            try:
                statuses += await client.describe(name)
                runs += await client.runs(name, limit)
            except BackendLost as error:
                silent.append(str(error))
        if not statuses and not silent:
            await client.describe()  # raises an error with the known executors
    return statuses, sorted(runs, key=lambda run: run.info.submitted, reverse=True)[:limit], silent


def _executor_row(status: ExecutorStatus) -> tuple[str, ...]:
    info, clock = status.info, status.clock
    timing = ("unknown", "unknown") if clock is None else (str(clock), f"{1000.0 * clock.round_trip:.1f} ms")
    return status.name, one_line(info.version), str(info.jobs), str(info.running), str(info.waiting), *timing


def _row(run: RemoteRun, now: float) -> tuple[str, ...]:
    """Format a run as a row; `now` is the time on the clock of its executor."""
    info = run.info
    duration = "" if info.started is None else _span((info.ended or now) - info.started)
    since = _span(now - (info.ended or info.started or info.submitted))
    texts = map(one_line, (info.by, info.file, info.waits))
    return run.id[:8], run.executor.name, _state(info), since, duration, *texts


def _state(info: RunInfo) -> str:
    place = "" if info.place is None else f" #{info.place}"
    return info.state.value + place + (f", priority {info.priority}" if place and info.priority else "")


def _span(seconds: float) -> str:
    for size, unit in _UNITS:
        if seconds >= size:
            return f"{seconds / size:.0f} {unit}"
    return f"{max(seconds, 0.0):.1f} s"
