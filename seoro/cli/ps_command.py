"""`seoro ps`: the runs of executors, and how these do."""

from __future__ import annotations

import argparse
import sys
import time
from typing import TYPE_CHECKING

import anyio

from seoro.cli.arguments import whole
from seoro.cli.exits import Exit
from seoro.cli.remote_arguments import add_executor_argument
from seoro.errors import BackendLost
from seoro.runtime.jsonl import to_json
from seoro.terminal_text import one_line

if TYPE_CHECKING:
    from seoro.bridges.executor.messages import RunInfo
    from seoro.client import ExecutorStatus
    from seoro.client.runs import RemoteRun

EXAMPLES = """examples:
  seoro ps
  seoro ps --on lab-a --json
  seoro ps --verbose

Of runs that wait, `queued #3` is the third; for whom others wait that need robots is in the last column. Times
are right though the executor's clock may not be."""
_TITLES = ("RUN", "EXECUTOR", "STATE", "SINCE", "TOOK", "BY", "FILE", "WAITING FOR")
_EXECUTOR_TITLES = ("EXECUTOR", "VERSION", "AT A TIME", "RUNNING", "WAITING", "CLOCK", "ROUND TRIP")
PATIENCE = 2.0  # [s] with an executor that does not answer
_UNITS = ((86_400, "d"), (3_600, "h"), (60, "min"))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--on", metavar="EXECUTOR", help="only the runs of this executor (default: of all)")
    add_executor_argument(parser)
    parser.add_argument(
        "--limit", type=whole, default=20, metavar="N", help="the N youngest runs (default: %(default)s)"
    )
    parser.add_argument(
        "--verbose", action="store_true", help="tell how the executors do, too: what they have to do, their clocks"
    )
    parser.add_argument(
        "--json", action="store_true", help="print a JSON list, with all that is known of each run"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    executors, found, silent = anyio.run(_look, options)
    for reason in silent:
        print(f"note: {one_line(reason)}: its runs are not listed", file=sys.stderr)
    status = Exit.ERROR if silent else Exit.PASSED
    ahead = {each.name: each.clock.offset if each.clock is not None else 0.0 for each in executors}
    if options.json:
        print(to_json([_plain(each) for each in found]))
        return status
    if options.verbose:
        _print_table([_EXECUTOR_TITLES, *map(_executor_row, executors)])
        print()
    if not found:
        print("there are no runs")
    else:
        rows = [_row(each, time.time() + ahead[each.executor.name]) for each in found]
        if not any(each.info.waits for each in found):
            rows = [row[:-1] for row in rows]
        _print_table([_TITLES[: len(rows[0])], *rows])
    return status


async def _look(options: argparse.Namespace) -> tuple[list[ExecutorStatus], list[RemoteRun], list[str]]:
    """How executors do, their runs, and of those that do not answer why."""
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
            await client.describe()  # says what there is instead
    return statuses, sorted(runs, key=lambda run: run.info.submitted, reverse=True)[:limit], silent


def _executor_row(status: ExecutorStatus) -> tuple[str, ...]:
    info, clock = status.info, status.clock
    told = ("unknown", "unknown") if clock is None else (str(clock), f"{1000.0 * clock.round_trip:.1f} ms")
    return status.name, one_line(info.version), str(info.jobs), str(info.running), str(info.waiting), *told


def _plain(run: RemoteRun) -> dict[str, object]:
    return {"executor": run.executor.name, **run.info.model_dump(mode="json")}


def _row(run: RemoteRun, now: float) -> tuple[str, ...]:
    """A run in the table; `now` is the time by the clock of its executor."""
    info = run.info
    took = "" if info.started is None else _span((info.ended or now) - info.started)
    since = _span(now - (info.ended or info.started or info.submitted))
    told = map(one_line, (info.by, info.file, info.waits))
    return run.id[:8], run.executor.name, _state(info), since, took, *told


def _state(info: RunInfo) -> str:
    place = "" if info.place is None else f" #{info.place}"
    return info.state.value + place + (f", priority {info.priority}" if place and info.priority else "")


def _span(seconds: float) -> str:
    for size, unit in _UNITS:
        if seconds >= size:
            return f"{seconds / size:.0f} {unit}"
    return f"{max(seconds, 0.0):.1f} s"


def _print_table(rows: list[tuple[str, ...]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip())
