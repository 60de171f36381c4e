"""`seoro trace`: look at the trace of a run."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Final

from seoro.cli.exits import Exit
from seoro.cli.output import paint, use_colour
from seoro.cli.results import silence
from seoro.errors import InvalidUse
from seoro.traces.choose import Choice, choose
from seoro.traces.perfetto import write_perfetto
from seoro.traces.read import Record, Unreadable, only_records, read_trace
from seoro.traces.summary import summarise
from seoro.traces.summary_text import summary_lines
from seoro.traces.timeline import timeline

NAME = "trace"
HELP = "show the trace of a run, sum it up, convert it"
EXAMPLES = """examples:
  seoro trace out/trace.jsonl
  seoro trace out/trace.jsonl --kind log --kind event --from 2 --to 5.5
  seoro trace out/trace.jsonl --path '*/nav_to_pose*'
  seoro trace out/trace.jsonl --summary
  seoro trace out/trace.jsonl --perfetto run.json     # open it in ui.perfetto.dev
  seoro exec maze.osc --trace - | seoro trace -

exit status: 0, also when the run was killed and its trace is cut off; 2 if it is no trace"""

_STDIN: Final = "-"
_TONES = {"failed": "31", "error": "31", "cancelled": "33", "warning": "33", "succeeded": "32", "debug": "2"}


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
    try:
        with _open(options.file) as file:
            return _Trace(options, file).show()
    except BrokenPipeError:  # whoever read the output has seen enough
        silence(sys.stdout)
        return Exit.PASSED


class _Trace:
    """One use of the command."""

    def __init__(self, options: argparse.Namespace, file: IO[bytes]) -> None:
        self._options = options
        self._problems: list[Unreadable] = []
        self._number = 0  # of records
        self._has_end = False
        self._file = file

    def show(self) -> Exit:
        """Do what is asked for.

        Raises:
            InvalidUse: It is no trace.
        """
        options = self._options
        if options.perfetto is not None and options.json:
            raise InvalidUse("`--json` prints, and `--perfetto` writes a file", help="leave one of them out")
        if options.perfetto is not None:
            self._convert(options.perfetto)
        elif options.summary:
            self._summarise()
        elif options.json:
            for record in self._chosen():
                print(json.dumps(record, ensure_ascii=False))
        else:
            self._print()
        sys.stdout.flush()
        self._say_what_is_missing()
        return Exit.PASSED

    def _records(self) -> Iterator[Record]:
        for record in only_records(read_trace(self._file), self._problems):
            self._number += 1
            self._has_end = self._has_end or record["kind"] == "run.end"
            yield record
        if not self._number:
            why = f": {self._problems[0]}" if self._problems else ": it is empty"
            raise InvalidUse(
                f"`{self._options.file}` is no trace{why}", help="`seoro exec --trace FILE` writes one"
            )

    def _chosen(self) -> Iterable[Record]:
        options = self._options
        start = -math.inf if options.start is None else options.start
        end = math.inf if options.end is None else options.end
        choice = Choice(options.kind, options.path, start, end, options.grep)
        return choose(self._records(), choice)

    def _print(self) -> None:
        on = use_colour(sys.stdout)
        for line in timeline(self._chosen(), is_whole=bool(self._options.kind)):
            print(paint(_TONES.get(line.tone, ""), str(line), on=on))

    def _summarise(self) -> None:
        summary = summarise(self._chosen(), self._problems)
        if self._options.json:
            print(json.dumps(summary.plain(), ensure_ascii=False))
        else:
            print("\n".join(summary_lines(summary)))

    def _convert(self, path: Path) -> None:
        try:
            with path.open("w", encoding="utf-8") as file:
                events = write_perfetto(self._chosen(), file)
        except BrokenPipeError:
            raise
        except OSError as error:
            raise InvalidUse(f"cannot write {path}: {error.strerror}") from error
        print(f"{events} events in {path}: open it in ui.perfetto.dev, which keeps it in your browser")

    def _say_what_is_missing(self) -> None:
        """Say on stderr what could not be read, and whether the run has no end."""
        said = [f"warning: {self._options.file}, {problem}" for problem in self._problems if not problem.is_cut]
        if not self._has_end:
            cut = " and its last line is cut off" if any(problem.is_cut for problem in self._problems) else ""
            said.append(f"warning: the run has no end here{cut}: it was killed, or is still going on")
        if said:
            print("\n".join(said), file=sys.stderr)


@contextmanager
def _open(name: str) -> Iterator[IO[bytes]]:
    if name == _STDIN:
        yield sys.stdin.buffer
        return
    with ExitStack() as opened:
        try:
            file = opened.enter_context(Path(name).open("rb"))
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
