"""`seoro compare`: find where two recorded runs first differ."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.trace_input import read_records, trace_of
from seoro.errors import UsageError
from seoro.text.printable import one_line
from seoro.traces.difference import Difference, Side, first_difference
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
    difference = first_difference(*runs)
    settings = list(_settings(*(found[0] for found in runs)))
    if options.json:
        found = None if difference is None else asdict(difference)
        print(json.dumps({"settings": settings, "difference": found}, ensure_ascii=False))
    else:
        for name, records in zip((options.first, options.second), runs, strict=True):
            print(one_line(f"{name}: {_verdict(records)}"))
        for name, first, second in settings:
            print(one_line(f"  {name}: {first} and {second}"))
        print("\n".join(_lines(difference)))
    return Exit.PASSED if difference is None and not settings else Exit.FAILED


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


def _settings(first: Record, second: Record) -> Iterator[tuple[str, str, str]]:
    """Yield the settings that differ: name, and both values."""
    for name in ("scenario", "seed", "clock", "version"):
        if first.get(name) != second.get(name):
            yield name, str(first.get(name)), str(second.get(name))
    ours, theirs = (found.get("parameters") or {} for found in (first, second))
    for name in sorted({**ours, **theirs}):
        if ours.get(name) != theirs.get(name):
            yield f"parameter {name}", json.dumps(ours.get(name)), json.dumps(theirs.get(name))
    hashes = [
        {source.get("name"): source.get("sha256") for source in found.get("sources") or ()}
        for found in (first, second)
    ]
    for name in sorted(set(hashes[0]) & set(hashes[1])):
        if hashes[0][name] != hashes[1][name]:
            yield f"text of {name}", str(hashes[0][name])[:8], str(hashes[1][name])[:8]


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
