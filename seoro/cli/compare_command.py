"""`seoro compare`: find where two recorded runs first differ."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import STDIN, write_errors
from seoro.cli.results import check_writable
from seoro.cli.trace_input import read_records, trace_of
from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.files.replacing import replacing
from seoro.report.comparison.page import comparison_page
from seoro.report.comparison.runs import compared_run
from seoro.text.printable import one_line
from seoro.traces.comparison import Comparison, compare_runs
from seoro.traces.difference import Difference
from seoro.traces.difference_text import common_line, side_lines
from seoro.traces.reader import Record

EXAMPLES = """examples:
  seoro compare before/ after/
  seoro compare passed.jsonl failed.jsonl
  seoro compare before/ after/ -o compare.html

Compares verdicts, parameters and what happened, without wall times, poses and orders within an instant.

exit status: 0 if the runs are equal, 1 if they differ, 2 if a trace is invalid"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("first", metavar="A", help="output folder of a run, or a trace")
    parser.add_argument("second", metavar="B", help="output folder of another run, or a trace")
    add_option(parser, "--json", "print the difference as one JSON object")
    add_option(parser, "-o --output FILE", "also write the comparison as a page, with the paths of robots")


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
    if options.output is not None:
        _write_page((options.first, options.second), runs, found, options.output)
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
    yield common_line(difference)
    if difference is not None:
        for letter, side in (("A", difference.first), ("B", difference.second)):
            yield f"  only in {letter}{'' if side.time is None else f', at {side.time:.3f} s'}:"
            yield from (f"    {one_line(line)}" for line in side_lines(side))


def _write_page(names: Sequence[str], runs: Sequence[list[Record]], found: Comparison, output: Path) -> None:
    check_writable(output)
    traces = [trace_of(name) for name in names]
    if any(trace != STDIN and resolved(Path(trace)) == resolved(output) for trace, _ in traces):
        raise UsageError(f"the page would overwrite the trace {output}", help="choose another output")
    first, second = (
        compared_run(name, records, folder) for name, records, (_, folder) in zip(names, runs, traces, strict=True)
    )
    with write_errors(output), replacing(output) as partial:
        text = "".join(comparison_page(first, second, found))
        partial.write_text(text, encoding="utf-8", newline="\n")
    print(f"wrote {output}: open it in a browser")
