"""`seoro trace`: look at the trace of a run."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO

from seoro.cli.exits import Exit
from seoro.cli.files import open_bytes
from seoro.cli.results import silence
from seoro.errors import InvalidUse

EXAMPLES = """examples:
  seoro trace out/trace.jsonl
  seoro trace out/trace.jsonl --kind log --kind event --from 2 --to 5.5
  seoro trace out/trace.jsonl --path '*/nav_to_pose*'
  seoro trace out/trace.jsonl --summary
  seoro trace out/trace.jsonl --perfetto run.json     # open it in ui.perfetto.dev
  seoro exec maze.osc --trace - | seoro trace -

exit status: 0, also when the run was killed and its trace is cut off; 2 if it is no trace"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", help="the trace (JSON Lines); - for stdin")
    parser.add_argument(
        "--kind", action="append", default=[], metavar="GLOB", help="records of this kind only (repeatable)"
    )
    parser.add_argument(
        "--path",
        action="append",
        default=[],
        metavar="GLOB",
        help="records about this only: the path of a behavior or variable, an event, an item (repeatable)",
    )
    parser.add_argument("--from", dest="start", type=_time, metavar="SECONDS", help="from this time on")
    parser.add_argument("--to", dest="end", type=_time, metavar="SECONDS", help="up to this time")
    parser.add_argument("--grep", type=_pattern, metavar="REGEX", help="records with this in one of their values")
    form = parser.add_mutually_exclusive_group()
    form.add_argument(
        "--summary", action="store_true", help="print the verdict, durations, what failed, and counts instead"
    )
    form.add_argument(
        "--perfetto", type=Path, metavar="OUT.json", help="write it as Chrome trace events for ui.perfetto.dev"
    )
    parser.add_argument(
        "--json", action="store_true", help="print JSON: the records, one a line, or the summary as one object"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from seoro.cli.trace_view import TraceView  # noqa: PLC0415 - other commands have no use for it

    try:
        with _open(options.file) as file:
            return TraceView(options, file).show()
    except BrokenPipeError:  # whoever read the output has seen enough
        silence(sys.stdout)
        return Exit.PASSED


@contextmanager
def _open(name: str) -> Iterator[IO[bytes]]:
    with ExitStack() as opened:
        try:
            file = opened.enter_context(open_bytes(name))
        except OSError as error:
            raise InvalidUse(f"cannot read {name}: {error.strerror}") from error
        yield file


def _time(text: str) -> float:
    try:
        return _finite(float(text.removesuffix("s")))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a time in seconds, not {text!r}") from None


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise ValueError
    return value


def _pattern(text: str) -> re.Pattern[str]:
    try:
        return re.compile(text)
    except re.error as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no regular expression: {error}") from None
