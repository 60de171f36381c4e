"""Output of runs on the terminal: progress, reasons and verdicts."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TextIO

from seoro.cli.results import silence
from seoro.cli.terminal import is_terminal, paint, terminal_columns, use_colour
from seoro.runtime.trace.writer import Writer, unbuffered
from seoro.runtime.verdict import Cancelled, ItemCoverage, RunStatus, Verdict
from seoro.text.printable import printable

if TYPE_CHECKING:
    import asyncio

    from seoro.cli.quiet_line import QuietLine

_QUIET = {"serial", "parallel", "one_of", "scenario", "wait", "emit"}  # only actions are printed

_MAX_ITEMS = 20  # of coverage and of clean-ups, on the terminal
_SHORT = 1.0  # [s] of the machine's clock; longer runs show what goes on while they are quiet
_RECENT = 5.0  # [s] of the run's clock, for the distance to a goal
_NOTICED = 0.1  # [s], shortest clean-up that is printed
_MAX_LINES = 100_000  # buffered for a stopped terminal, or a pipe without a reader

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


def print_reason(verdict: Verdict) -> None:
    """Print on stderr the reason of a run that did not pass."""
    if not verdict.reason:
        return
    from seoro.runtime.explain.reasons import reason_text  # noqa: PLC0415 - for runs that did not pass

    width = terminal_columns() if sys.stderr.isatty() else None
    text = reason_text(verdict, colour=use_colour(sys.stderr), width=width)
    print("\n" + text, file=sys.stderr)


def _contact_text(arguments: Mapping[str, Any]) -> str:
    """Format a contact event: the mover and the other object, if known."""
    first, second = arguments["first"], arguments["second"]
    strikers = arguments.get("strikers")
    if not strikers or len(strikers) > 1:
        return f"{first} touches {second}"
    [striker] = strikers
    if striker not in (first, second):
        return f"{first} touches {second}, moved by {striker}"
    other = second if striker == first else first
    return f"{striker} {'pushes' if arguments.get('pushes') else 'moves into'} {other}"


def _clean_up_text(cancelled: Cancelled) -> str:
    """Format the clean-up of an action."""
    name = cancelled.path.rpartition("/")[2]
    too_long = ", longer than allowed" if cancelled.overran else ""
    return f"clean-up of {name} ({cancelled.span}) took {cancelled.clean_up:.2f} s{too_long}"


def _coverage_text(item: ItemCoverage) -> str:
    """Format the grade of a coverage item."""
    reached = f"{item.reached} of {item.total} buckets ({item.grade:.0%})"
    return f"{item.item}: {reached}" + (f", {item.illegal} illegal" if item.illegal else "")


class Progress:
    """Trace observer that prints the progress of a run without blocking it.

    If the reader closes the pipe, like `| head`, output is dropped and the run continues. Lines that a terminal
    does not accept in time are skipped, with a note.

    Args:
        file: Output file.
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
        self._left: dict[str, tuple[float, float]] = {}  # time and distance to the goal [m], by robot
        self._actions: dict[int, str] = {}  # running ones
        self._quiet: QuietLine | None = None
        self._starting: asyncio.TimerHandle | None = None

    def record(self, record: dict[str, Any]) -> None:
        """Print a record of the trace."""
        match record["kind"]:
            case "behavior.start" if record["type"] not in _QUIET:
                self._running[record["id"]] = (record["name"], record["t"])
                if record["type"] == "action":
                    self._actions[record["id"]] = record["name"]
                if record["name"] != "log":
                    self._line(record["t"], "", ">", record["name"])
            case "behavior.end" if record["id"] in self._running:
                self._end(record)
            case "log":
                self._line(record["t"], _LEVELS.get(record["level"], ""), " ", str(record["message"]))
            case "event" if record["name"] == "contact":
                arguments = record["arguments"]
                self._line(record["t"], _RED, "!", _contact_text(arguments))
            case "event" if record["name"] == "navigation_feedback":
                self._recoveries(record)

    def _recoveries(self, record: dict[str, Any]) -> None:
        """Note the distance to the goal, and print a line if a robot has recovered since its last feedback."""
        robot, count = record["arguments"]["robot"], record["arguments"]["number_of_recoveries"]
        left = record["arguments"]["distance_remaining"]
        self._left[robot] = (record["t"], left)
        if count > self._recovered.get(robot, 0):
            self._line(
                record["t"], _RED, "!", f"{robot} was blocked and is recovering, {left:.1f} m from its goal"
            )
        self._recovered[robot] = count

    def _end(self, record: dict[str, Any]) -> None:
        name, started = self._running.pop(record["id"])
        self._actions.pop(record["id"], None)
        if name == "log":
            return
        mark, style = _MARKS[record["status"]]
        duration = f" after {record['t'] - started:.2f} s" if record["t"] > started else ""
        self._line(record["t"], style, mark, f"{name}  {record['status']}{duration}")

    def _line(self, time: float, style: str, mark: str, text: str) -> None:
        stamp = self._paint(_DIM, f"{time:9.3f} s")
        for part in printable(text).split("\n"):
            self.print_line(f"{stamp}  " + self._paint(style, f"{mark} {part}"))

    def _paint(self, style: str, text: str) -> str:
        return paint(style, text, on=self._colour)

    def print_line(self, text: str) -> None:
        """Print a line."""
        if self._writer.waiting >= _MAX_LINES:
            self._left_out += 1
            return
        if self._left_out:
            text = f"... skipped {self._left_out} lines: the terminal was too slow\n{text}"
            self._left_out = 0
        self._put(f"{self._quiet.prefix() if self._quiet is not None else ''}{text}\n")

    def _put(self, text: str) -> None:
        with suppress(OSError):
            self._writer.put(text)

    def _quiet_text(self, now: float) -> str:
        """Return the time, running actions, and recent distances to goals."""
        names = dict.fromkeys(self._actions.values())
        if not names:
            return f"{now:9.3f} s  waiting"
        recent = {robot: left for robot, (moment, left) in self._left.items() if now - moment < _RECENT}
        goals = "".join(f"; {robot}: {left:.1f} m left" for robot, left in recent.items())
        return printable(f"{now:9.3f} s  {', '.join(names)}{goals}")

    def print_output(self, line: str) -> None:
        """Print a line of output of the process of the run."""
        self.print_line(printable(line))

    def set_clock(self, clock: Callable[[], float]) -> None:
        """Show what goes on whenever the run prints nothing for a while."""
        import asyncio  # noqa: PLC0415 - loaded by then, unlike in commands that run nothing

        self._stop_quiet()
        self._starting = asyncio.get_running_loop().call_later(_SHORT, self._start_quiet, clock)

    def _start_quiet(self, clock: Callable[[], float]) -> None:
        from seoro.cli.quiet_line import QuietLine  # noqa: PLC0415 - for longer runs

        self._quiet = QuietLine(self._put, self._quiet_text, is_terminal(self._file), terminal_columns())
        self._quiet.start(clock)

    def _stop_quiet(self) -> None:
        if self._starting is not None:
            self._starting.cancel()
        if self._quiet is not None:
            self._quiet.stop()

    async def end_of_run(self) -> None:
        """Show no more what goes on; later lines are printed like those before."""
        self._stop_quiet()

    async def finish(self) -> None:
        """Wait until all output is printed."""
        self._stop_quiet()
        try:
            await self._writer.finish()
        except OSError:
            silence(self._file)

    def print_verdict(self, verdict: Verdict) -> None:
        """Print the verdict of a run."""
        status = self._paint(_STATUS_STYLES[verdict.status], verdict.status.value)
        times = f"{verdict.duration:.2f} s of its clock, {verdict.wall_duration:.2f} s real"
        self.print_line(f"\n{status}  {verdict.scenario} in {times}")
        slow = [each for each in verdict.cancelled if each.type == "action" and each.clean_up >= _NOTICED]
        self._print_first(map(_clean_up_text, slow), "clean-ups")
        if verdict.unobserved:
            self.print_line(f"  contacts not observed: {', '.join(verdict.unobserved)}")
        graded = [item for item in verdict.coverage if item.grade is not None]
        self._print_first(map(_coverage_text, graded), "items")

    def _print_first(self, texts: Iterable[str], what: str) -> None:
        """Print texts, and the number of those beyond the limit."""
        lines = list(texts)
        for line in lines[:_MAX_ITEMS]:
            self.print_line(f"  {line}")
        if len(lines) > _MAX_ITEMS:
            self.print_line(f"  and {len(lines) - _MAX_ITEMS} more {what} (`--json` lists all)")
