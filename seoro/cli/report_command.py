"""`seoro report`: write a page that shows a recorded run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from seoro.cli.arguments import add_option
from seoro.cli.files import STDIN, write_errors
from seoro.cli.results import check_writable
from seoro.cli.trace_input import open_trace, trace_of
from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.files.replacing import replacing
from seoro.report.page import REPORT, NoRecords, write_report
from seoro.report.reading import Reading

EXAMPLES = """examples:
  seoro report out/
  seoro report out/ -o obstacle.html
  seoro report trace.jsonl
  seoro report out/ --3d
  seoro report campaign/kept/*
  seoro exec maze.osc --trace - | seoro report - -o maze.html

The report is one HTML file. A browser opens it without a network.

exit status: 0, also for the truncated trace of a killed run; 2 if the trace is invalid"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "recorded", metavar="RUN", nargs="+", help="output folder of a run, or a trace (JSON Lines); - for stdin"
    )
    add_option(parser, "-o --output FILE", f"the report (default: {REPORT} beside the trace)")
    add_option(parser, "--3d", "show the world in three dimensions, too; adds 0.6 MB", dest="space")


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    if options.output is not None and len(options.recorded) > 1:
        raise UsageError("`--output` is for one run", help="leave it out, or name one run")
    for recorded in options.recorded:
        _report(recorded, options.output, space=options.space)


def _report(recorded: str, named: Path | None, *, space: bool) -> None:
    """Write the report of a run to the named file, by default beside its trace."""
    trace, folder = trace_of(recorded)
    output = named or Path(folder or ".", REPORT)
    if trace != STDIN and resolved(output) == resolved(Path(trace)):
        raise UsageError(f"the report would overwrite {trace}", help="choose another output")
    reading = write_file(trace, folder, output, space=space)
    print(f"wrote {output}, {output.stat().st_size / 1e6:.1f} MB: open it in a browser")
    if reading.end is None:
        print(f"warning: {trace} has no `run.end`: the run was killed, or is still active", file=sys.stderr)


def write_file(trace: str, folder: Path | None, output: Path, *, space: bool = False) -> Reading:
    """Write a report.

    Args:
        trace: The trace; `-` is stdin.
        folder: Folder with other results of the run; None for none.
        output: The report.
        space: Whether the report can show the world in three dimensions.

    Returns:
        Data of the trace.

    Raises:
        UsageError: The trace cannot be read or is invalid, or the report cannot be written.
    """
    with open_trace(trace) as records:
        check_writable(output)
        try:
            with (
                write_errors(output),
                replacing(output) as partial,
                partial.open("w", encoding="utf-8", newline="\n") as file,
            ):
                return write_report(records, folder, file, space=space)
        except NoRecords as found:
            raise UsageError(
                f"invalid trace {trace}: {found}", help="`seoro exec --trace FILE` writes a trace"
            ) from found
