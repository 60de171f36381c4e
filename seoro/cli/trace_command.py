"""`seoro trace`: print, filter, summarise or convert the trace of a run."""

from __future__ import annotations

import argparse
import json
import math
import shutil
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

from seoro.cli.arguments import add_option, given_option, number, pattern
from seoro.cli.files import write_errors
from seoro.cli.recordings import write as write_recording
from seoro.cli.recordings import write_bag
from seoro.cli.results import silence
from seoro.cli.terminal import paint, use_colour
from seoro.cli.trace_input import invalid_trace, open_trace
from seoro.errors import UsageError
from seoro.runtime.execution.outputs import VIDEO
from seoro.traces.causes import CauseIndex, steps
from seoro.traces.perfetto import write_perfetto
from seoro.traces.reader import Filter, InvalidRecord, Record, read_trace, select, valid_records
from seoro.traces.summary import summarise
from seoro.traces.summary_text import summary_lines
from seoro.traces.timeline import timeline

EXAMPLES = """examples:
  seoro trace out/trace.jsonl
  seoro trace out/trace.jsonl --kind log --kind event --from 2 --to 5.5
  seoro trace out/trace.jsonl --path '*/nav_to_pose*'
  seoro trace out/trace.jsonl --summary
  seoro trace out/trace.jsonl --why end
  seoro trace out/trace.jsonl --perfetto run.json     # open it in ui.perfetto.dev
  seoro trace out/trace.jsonl --mcap run.mcap         # open it in Foxglove
  seoro trace out/trace.jsonl --bag run_bag           # play it in ROS 2
  seoro exec maze.osc --trace - | seoro trace -

exit status: 0, also for the truncated trace of a killed run; 2 if the trace is invalid"""

END = "end"  # `--why` of the end of the run

_number_of_record = number("the number of a record, or `end`", int, lambda value: value >= 0)
_seconds = number("a time in seconds", float, math.isfinite)
_TONES = {"failed": "31", "error": "31", "cancelled": "33", "warning": "33", "succeeded": "32", "debug": "2"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", help="trace (JSON Lines); - for stdin")
    add_option(parser, "--kind GLOB", "select records of this kind", repeatable=True)
    add_option(
        parser, "--path GLOB", "select records of this behavior, variable, event or coverage item", repeatable=True
    )
    add_option(parser, "--from SECONDS", "select records from this time on", dest="start", type=_time)
    add_option(parser, "--to SECONDS", "select records up to this time", dest="end", type=_time)
    add_option(parser, "--grep REGEX", "select records with a matching value", type=pattern)
    form = parser.add_mutually_exclusive_group()
    add_option(
        form,
        "--why RECORD",
        "follow the causes of a record back to the start of the run: its number (`--numbers`), or `end`",
        type=_record,
    )
    add_option(form, "--summary", "print verdict, durations, failures and counts instead")
    add_option(
        form, "--mcap OUT.mcap", "write a recording for Foxglove, with foxglove-layout.json beside it", type=Path
    )
    add_option(
        form, "--bag DIR", "write a bag of ROS 2 (rosbag2, MCAP) with poses, scans, map and logs", type=Path
    )
    add_option(parser, "--video FILE", f"film of the run for `--mcap` or `--bag`, such as its {VIDEO}")
    add_option(form, "--perfetto OUT.json", "write Chrome trace events for ui.perfetto.dev", type=Path)
    add_option(parser, "--numbers", "print the number of each record")
    add_option(parser, "--json", "print records as JSON Lines, or the summary as one JSON object")


@contextmanager
def _reread(file: IO[bytes]) -> Iterator[IO[bytes]]:
    """Provide a trace that can be read twice; a pipe is copied to a temporary file."""
    if file.seekable():
        yield file
        return
    with TemporaryFile() as copy:
        shutil.copyfileobj(file, copy)
        copy.seek(0)
        yield copy


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    try:
        with open_trace(options.file) as file:
            _TraceView(options, file).show()
    except BrokenPipeError:  # the reader has closed the pipe
        silence(sys.stdout)


def _record(text: str) -> int | str:
    return text if text == END else _number_of_record(text)


def _time(text: str) -> float:
    return _seconds(text.removesuffix("s"))


class _TraceView:
    """Run of the command."""

    def __init__(self, options: argparse.Namespace, file: IO[bytes]) -> None:
        self._options = options
        self._problems: list[InvalidRecord] = []
        self._kinds: Counter[str] = Counter()  # of records
        self._chosen_number = 0
        self._file = file

    def show(self) -> None:
        """Print, summarise or convert the trace.

        Raises:
            UsageError: The trace is invalid.
        """
        options = self._options
        if options.json and (given := given_option(options, "perfetto", "mcap", "bag")):
            raise UsageError(f"`--json` contradicts `{given}`", help="leave out one of them")
        if options.video is not None and options.mcap is None and options.bag is None:
            raise UsageError("`--video` needs `--mcap` or `--bag`", help="name the recording: `--mcap run.mcap`")
        if options.perfetto is not None:
            self._convert(options.perfetto)
        elif options.mcap is not None:
            write_recording(self._chosen(), options.mcap, options.video)
        elif options.bag is not None:
            write_bag(self._chosen(), options.bag, options.video)
        elif options.why is not None:
            self._explain(options.why)
        elif options.summary:
            summary = summarise(self._chosen(), self._problems)
            plain = json.dumps(summary.plain(), ensure_ascii=False) if options.json else None
            print(plain or "\n".join(summary_lines(summary)))
        elif options.json:
            for record in self._chosen():
                print(json.dumps(record, ensure_ascii=False))
        else:
            on = use_colour(sys.stdout)
            for line in timeline(self._chosen(), is_whole=bool(options.kind)):
                number = f"  #{line.number}" if options.numbers else ""
                print(paint(_TONES.get(line.tone, ""), f"{line}{number}", on=on))
        sys.stdout.flush()
        self._print_warnings()

    def _records(self) -> Iterator[Record]:
        return self._records_of(self._file)

    def _records_of(self, file: IO[bytes]) -> Iterator[Record]:
        for record in valid_records(read_trace(file), self._problems):
            self._kinds[record["kind"]] += 1
            yield record
        if not self._kinds:
            raise invalid_trace(self._options.file, self._problems)

    def _chosen(self) -> Iterator[Record]:
        options = self._options
        start = -math.inf if options.start is None else options.start
        end = math.inf if options.end is None else options.end
        choice = Filter(options.kind, options.path, start, end, options.grep)
        for record in select(self._records(), choice):
            self._chosen_number += 1
            yield record

    def _explain(self, wanted: int | str) -> None:
        """Print the causes of a record, the record first.

        Raises:
            UsageError: The trace has no such record, or no causes.
        """
        with _reread(self._file) as file:
            index = CauseIndex(self._records_of(file))
            if wanted == END and index.end is None:
                raise UsageError("the trace has no end of the run", help="give the number of a record")
            if not index.is_whole:
                raise UsageError("records are missing from the trace", help="give the trace that the run wrote")
            number = index.end if wanted == END else wanted
            if not isinstance(number, int) or number >= len(index):
                raise UsageError(f"no record {wanted}; the trace has the records 0 to {len(index) - 1}")
            if not index.knows_any:
                raise UsageError(
                    "the trace has no causes: it was written by an older version of seoro",
                    help="run the scenario again",
                )
            file.seek(0)
            found = steps(valid_records(read_trace(file), []), index.chain(number))
        self._chosen_number = len(found)
        for step in found:
            print(json.dumps(step.record, ensure_ascii=False) if self._options.json else step)

    def _convert(self, path: Path) -> None:
        with write_errors(path), path.open("w", encoding="utf-8") as file:
            events = write_perfetto(self._chosen(), file)
        print(f"wrote {events} events to {path}: open it in ui.perfetto.dev (the file stays in your browser)")

    def _print_warnings(self) -> None:
        """Print warnings on stderr about unreadable lines and a missing end."""
        lines = [f"warning: {self._options.file}, {problem}" for problem in self._problems if not problem.is_cut]
        if not self._chosen_number:
            kinds = ", ".join(sorted(self._kinds))
            lines.append(f"note: none of {self._kinds.total()} records matches; kinds: {kinds}")
        if "run.end" not in self._kinds:
            cut = ", the last line is truncated" if any(problem.is_cut for problem in self._problems) else ""
            lines.append(f"warning: the trace has no `run.end`{cut}: the run was killed, or is still active")
        if lines:
            print("\n".join(lines), file=sys.stderr)
