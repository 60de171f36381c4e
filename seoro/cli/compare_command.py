"""`seoro compare`: find where two recorded runs first differ."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.trace_input import read_records, trace_of
from seoro.errors import UsageError
from seoro.text.printable import one_line
from seoro.traces.comparison import compare_runs
from seoro.traces.difference import Difference, Side
from seoro.traces.reader import Record
from seoro.traces.timeline import MARKS, timeline

EXAMPLES = """examples:
  seoro compare before/ after/
  seoro compare passed.jsonl failed.jsonl

Compares verdicts, parameters and what happened, without wall times, poses and orders within an instant.

exit status: 0 if the runs are equal, 1 if they differ, 2 if a trace is invalid"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("first", metavar="A", help="output folder of a run, or a trace")
    parser.add_argument("second", metavar="B", help="output folder of another run, or a trace")
    add_option(parser, "--json", "print the difference as one JSON object")


def run(options: argparse.Namespace) -> Exit:
    """Run the command."""
    runs = [_read(name) for name in (options.first, options.second)]
    found = compare_runs(*runs)
    if options.json:
        print(json.dumps(found.data, ensure_ascii=False))
    else:
        for name, records in zip((options.first, options.second), runs, strict=True):
            print(one_line(f"{name}: {_verdict(records)}"))
        for name, first, second in found.settings:
            print(one_line(f"  {name}: {first} and {second}"))
        print("\n".join(_lines(found.difference)))
    return Exit.PASSED if found.is_equal else Exit.FAILED


def _read(name: str) -> list[Record]:
    trace, _ = trace_of(name)
    found = read_records(trace)
    if found[0]["kind"] != "run.start":
        raise UsageError(f"the trace {trace} has no beginning", help="compare traces of whole runs")
    return found


def _verdict(records: list[Record]) -> str:
    start, end = records[0], records[-1]
    if end["kind"] != "run.end":
        return f"{start['scenario']} has no end after {end['t']:.3f} s"
    reason = f": {end['reason']}" if end["reason"] else ""
    return f"{start['scenario']} {end['status']} after {end['t']:.3f} s{reason}"


def _lines(difference: Difference | None) -> Iterator[str]:
    if difference is None:
        yield "equal: everything happened at the same times"
        return
    if difference.common is None:
        yield "the runs differ from the start"
    else:
        yield f"equal until {difference.common:.3f} s, then:"
    for letter, side in (("A", difference.first), ("B", difference.second)):
        yield f"  only in {letter}{'' if side.time is None else f', at {side.time:.3f} s'}:"
        yield from (f"    {one_line(line)}" for line in _side(side))


def _side(side: Side) -> Iterator[str]:
    if side.time is None:
        yield "nothing: the run had ended"
    elif not side.records:
        yield "nothing"
    for record in side.records:
        yield _line(record)


def _line(record: Record) -> str:
    """Format a record in a line."""
    if record["kind"] == "behavior.end":
        reason = f": {record['reason']}" if record.get("reason") else ""
        return f"{MARKS.get(record['status'], '?')} {record['path']} {record['status']}{reason}"
    shown = next(timeline([record], is_whole=True), None)
    return record["kind"] if shown is None else f"{shown.mark} {shown.text} {shown.note}".rstrip()
