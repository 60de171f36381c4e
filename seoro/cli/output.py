"""What people see: errors with their place in the scenario, the progress of a run, its end."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import IO, Any, TextIO

from seoro.cli.error_diagnostics import diagnostics_of
from seoro.cli.results import silence
from seoro.errors import BackendUnreachable, InvalidUse
from seoro.lang.render import render_text
from seoro.reasons import reason_text
from seoro.runtime.tally import ItemCoverage
from seoro.runtime.verdict import Cancelled, RunStatus, Verdict
from seoro.runtime.writer import Writer, unbuffered
from seoro.terminal_text import printable

_QUIET = {"serial", "parallel", "one_of", "scenario", "wait", "emit"}  # what people follow are the actions

_MAX_ITEMS = 20  # of coverage and of clean-ups, on the terminal
_NOTICED = 0.1  # [s] of a clean-up that people are told of
_MAX_LINES = 100_000  # that wait for a terminal that was stopped, or a pipe that nobody reads

# Select Graphic Rendition (ECMA-48).
_RED, _GREEN, _YELLOW, _DIM = "31", "32", "33", "2"
_MARKS = {"succeeded": ("+", _GREEN), "failed": ("x", _RED), "cancelled": ("-", _YELLOW)}
_LEVELS = {"warning": _YELLOW, "error": _RED, "debug": _DIM}
_STATUS_STYLES = {
    RunStatus.PASSED: "1;32",
    RunStatus.FAILED: "1;31",
    RunStatus.ERROR: "1;35",
    RunStatus.CANCELLED: "1;33",
}


def use_colour(file: IO[str]) -> bool:
    """Whether a file is a terminal of someone who has not refused colours."""
    return is_terminal(file) and not os.environ.get("NO_COLOR")


def is_terminal(file: IO[str]) -> bool:
    """Whether a file is a terminal that can do more than print."""
    return file.isatty() and os.environ.get("TERM") != "dumb"


def paint(style: str, text: str, *, on: bool) -> str:
    """A text in a style, as parameters of Select Graphic Rendition (ECMA-48); as it is if not `on`, or without."""
    return f"\x1b[{style}m{text}\x1b[0m" if on and style else text


def print_error(error: Exception) -> None:
    """Print an error on stderr; with the text of the scenario, where there is one."""
    print(error_text(error, colour=use_colour(sys.stderr)), file=sys.stderr)


def error_text(error: Exception, colour: bool = False) -> str:
    """An error for people; with the text of the scenario, where there is one."""
    if diagnostics := diagnostics_of(error):
        return "\n\n".join(render_text(found, colour=colour) for found in diagnostics)
    match error:
        case InvalidUse(help=hint) | BackendUnreachable(help=hint) if hint:
            return printable(f"error: {error}\n  = help: {hint}")
        case _:
            return printable(f"error: {error}")


def print_reason(verdict: Verdict) -> None:
    """Print on stderr why a run did not pass."""
    width = shutil.get_terminal_size().columns if sys.stderr.isatty() else None
    text = reason_text(verdict, colour=use_colour(sys.stderr), width=width)
    if text:
        print("\n" + text, file=sys.stderr)


def _touch(arguments: Mapping[str, Any]) -> str:
    """A contact in a line: who moved into whom, where that is known."""
    first, second = arguments["first"], arguments["second"]
    strikers = arguments.get("strikers")
    if not strikers or len(strikers) > 1:
        return f"{first} touches {second}"
    [striker] = strikers
    if striker not in (first, second):
        return f"{first} touches {second}, moved by {striker}"
    other = second if striker == first else first
    return f"{striker} {'pushes' if arguments.get('pushes') else 'moves into'} {other}"


class Progress:
    """Prints what happens in a run, as it happens, without holding up the run.

    When nobody reads it any more, as after `| head`, it falls silent, and the run goes on. Lines that a terminal
    does not take in time are left out, and it says so.

    Args:
        file: Where to.
    """

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self._colour = use_colour(file)
        self._writer = Writer[str](
            unbuffered(file), "terminal", lambda line: line.encode(file.encoding, "replace")
        )
        self._running: dict[int, tuple[str, float]] = {}
        self._left_out = 0
        self._recovered: dict[str, int] = {}

    def record(self, record: dict[str, Any]) -> None:
        """An observer of the trace."""
        match record["kind"]:
            case "behavior.start" if record["type"] not in _QUIET:
                self._running[record["id"]] = (record["name"], record["t"])
                if record["name"] != "log":
                    self._line(record["t"], "", ">", record["name"])
            case "behavior.end" if record["id"] in self._running:
                self._end(record)
            case "log":
                self._line(record["t"], _LEVELS.get(record["level"], ""), " ", str(record["message"]))
            case "event" if record["name"] == "contact":
                arguments = record["arguments"]
                self._line(record["t"], _RED, "!", _touch(arguments))
            case "event" if record["name"] == "navigation_feedback":
                self._recoveries(record)

    def _recoveries(self, record: dict[str, Any]) -> None:
        """A line when a robot has had to recover since it last said how far it is."""
        robot, count = record["arguments"]["robot"], record["arguments"]["number_of_recoveries"]
        if count > self._recovered.get(robot, 0):
            left = record["arguments"]["distance_remaining"]
            self._line(record["t"], _RED, "!", f"{robot} was blocked and recovers, {left:.1f} m from its goal")
        self._recovered[robot] = count

    def _end(self, record: dict[str, Any]) -> None:
        name, started = self._running.pop(record["id"])
        if name == "log":
            return
        mark, style = _MARKS[record["status"]]
        took = f" after {record['t'] - started:.2f} s" if record["t"] > started else ""
        self._line(record["t"], style, mark, f"{name}  {record['status']}{took}")

    def _line(self, time: float, style: str, mark: str, text: str) -> None:
        stamp = self._paint(_DIM, f"{time:9.3f} s")
        for part in printable(text).split("\n"):
            self.say(f"{stamp}  " + self._paint(style, f"{mark} {part}"))

    def _paint(self, style: str, text: str) -> str:
        return paint(style, text, on=self._colour)

    def say(self, text: str) -> None:
        """Print a line."""
        if self._writer.waiting >= _MAX_LINES:
            self._left_out += 1
            return
        if self._left_out:
            text = f"... {self._left_out} lines are left out: they were not taken in time\n{text}"
            self._left_out = 0
        with suppress(OSError):
            self._writer.put(text + "\n")

    def printed(self, line: str) -> None:
        """Print a line that the process of the run has printed elsewhere."""
        self.say(printable(line))

    def follow(self, clock: Callable[[], float]) -> None:
        """What shows time as it goes on follows a clock; lines have the times of their records."""

    async def end_of_run(self) -> None:
        """Nothing more comes of the run: what is said from now on is about it."""

    async def finish(self) -> None:
        """Wait until everything is printed."""
        try:
            await self._writer.finish()
        except OSError:
            silence(self._file)

    def verdict(self, verdict: Verdict) -> None:
        """Print the end of a run."""
        status = self._paint(_STATUS_STYLES[verdict.status], verdict.status.value)
        times = f"{verdict.duration:.2f} s of its clock, {verdict.wall_duration:.2f} s real"
        self.say(f"\n{status}  {verdict.scenario} in {times}")
        self._clean_ups(
            [each for each in verdict.cancelled if each.type == "action" and each.clean_up >= _NOTICED]
        )
        if verdict.unobserved:
            self.say(f"  contacts unobserved: {', '.join(verdict.unobserved)}")
        self._coverage([item for item in verdict.coverage if item.grade is not None])

    def _clean_ups(self, cancelled: Sequence[Cancelled]) -> None:
        """Print which actions took noticeably long to clean up."""
        for each in cancelled[:_MAX_ITEMS]:
            name = each.path.rpartition("/")[2]
            too_long = ", longer than it may" if each.overran else ""
            self.say(f"  the clean-up of {name} ({each.span}) took {each.clean_up:.2f} s{too_long}")
        if len(cancelled) > _MAX_ITEMS:
            self.say(f"  and {len(cancelled) - _MAX_ITEMS} more clean-ups: `--json` has all of them")

    def _coverage(self, items: Sequence[ItemCoverage]) -> None:
        """Print how much of the goals of coverage was reached."""
        for item in items[:_MAX_ITEMS]:
            reached = f"{item.reached} of {item.total} buckets ({item.grade:.0%})"
            self.say(f"  {item.item}: {reached}" + (f", {item.illegal} illegal" if item.illegal else ""))
        if len(items) > _MAX_ITEMS:
            self.say(f"  and {len(items) - _MAX_ITEMS} more items: `--json` has all of them")
