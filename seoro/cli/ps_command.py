"""`seoro ps`: the runs of executors."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

import anyio

from seoro.cli.arguments import whole
from seoro.cli.exits import Exit
from seoro.cli.output import printable
from seoro.cli.remote_arguments import add_executor_argument
from seoro.runtime.jsonl import to_json

if TYPE_CHECKING:
    from seoro.client.runs import RemoteRun

EXAMPLES = """examples:
  seoro ps
  seoro ps --on lab-a --json"""
_TITLES = ("RUN", "EXECUTOR", "STATE", "SINCE", "TOOK", "BY", "FILE")
_UNITS = ((86_400, "d"), (3_600, "h"), (60, "min"))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--on", metavar="EXECUTOR", help="only the runs of this executor (default: of all)")
    add_executor_argument(parser)
    parser.add_argument(
        "--limit", type=whole, default=20, metavar="N", help="the N youngest runs (default: %(default)s)"
    )
    parser.add_argument(
        "--json", action="store_true", help="print a JSON list, with all that is known of each run"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    found = anyio.run(_runs, options)
    if options.json:
        print(to_json([_plain(each) for each in found]))
    elif not found:
        print("there are no runs")
    else:
        _print_table([_TITLES, *map(_row, found)])
    return Exit.PASSED


async def _runs(options: argparse.Namespace) -> list[RemoteRun]:
    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for this command only

    async with Client(options.executor) as client:
        return await client.runs(options.on, min(options.limit, 1000))


def _plain(run: RemoteRun) -> dict[str, object]:
    return {"executor": run.executor.name, **run.info.model_dump(mode="json")}


def _row(run: RemoteRun) -> tuple[str, ...]:
    info, now = run.info, time.time()
    took = "" if info.started is None else _span((info.ended or now) - info.started)
    since = _span(now - (info.ended or info.started or info.submitted))
    return run.id[:8], run.executor.name, info.state.value, since, took, printable(info.by), printable(info.file)


def _span(seconds: float) -> str:
    for size, unit in _UNITS:
        if seconds >= size:
            return f"{seconds / size:.0f} {unit}"
    return f"{max(seconds, 0.0):.1f} s"


def _print_table(rows: list[tuple[str, ...]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip())
