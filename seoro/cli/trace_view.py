"""What `seoro trace` does with a trace: show it, sum it up, convert it."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from seoro.cli.exits import Exit
from seoro.cli.output import paint, use_colour
from seoro.errors import InvalidUse
from seoro.traces.choose import Choice, choose
from seoro.traces.perfetto import write_perfetto
from seoro.traces.read import Record, Unreadable, only_records, read_trace
from seoro.traces.summary import summarise
from seoro.traces.summary_text import summary_lines
from seoro.traces.timeline import timeline

_TONES = {"failed": "31", "error": "31", "cancelled": "33", "warning": "33", "succeeded": "32", "debug": "2"}


class TraceView:
    """One use of the command."""

    def __init__(self, options: argparse.Namespace, file: IO[bytes]) -> None:
        self._options = options
        self._problems: list[Unreadable] = []
        self._number = 0  # of records
        self._chosen_number = 0
        self._kinds: set[str] = set()
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
            self._kinds.add(record["kind"])
            self._has_end = self._has_end or record["kind"] == "run.end"
            yield record
        if not self._number:
            why = f": {self._problems[0]}" if self._problems else ": it is empty"
            raise InvalidUse(
                f"`{self._options.file}` is no trace{why}", help="`seoro exec --trace FILE` writes one"
            )

    def _chosen(self) -> Iterator[Record]:
        options = self._options
        start = -math.inf if options.start is None else options.start
        end = math.inf if options.end is None else options.end
        choice = Choice(options.kind, options.path, start, end, options.grep)
        for record in choose(self._records(), choice):
            self._chosen_number += 1
            yield record

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
        if not self._chosen_number:
            kinds = ", ".join(sorted(self._kinds))
            said.append(f"note: none of its {self._number} records was chosen; there are {kinds}")
        if not self._has_end:
            cut = " and its last line is cut off" if any(problem.is_cut for problem in self._problems) else ""
            said.append(f"warning: the run has no end here{cut}: it was killed, or is still going on")
        if said:
            print("\n".join(said), file=sys.stderr)
