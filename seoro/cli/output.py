"""What people see: errors with their place in the scenario, the progress of a run, its end."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import IO, Any

from rich.console import Console
from rich.text import Text

from seoro.errors import InvalidScenario, InvalidUse
from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.render import render_text
from seoro.lang.source import Span
from seoro.runtime.tally import ItemCoverage
from seoro.runtime.verdict import RunStatus, Verdict

_QUIET = {"serial", "parallel", "one_of", "scenario", "wait", "emit"}  # what people follow are the actions

_MAX_ITEMS = 20  # of coverage, on the terminal
_MARKS = {"succeeded": ("+", "green"), "failed": ("x", "red"), "cancelled": ("-", "yellow")}

_STATUS_STYLES = {
    RunStatus.PASSED: "bold green",
    RunStatus.FAILED: "bold red",
    RunStatus.ERROR: "bold magenta",
    RunStatus.CANCELLED: "bold yellow",
}


def use_colour(file: IO[str]) -> bool:
    """Whether a file is a terminal of someone who has not refused colours."""
    return file.isatty() and not os.environ.get("NO_COLOR")


def print_error(error: Exception) -> None:
    """Print an error on stderr; with the text of the scenario, where there is one."""
    colour = use_colour(sys.stderr)
    match error:
        case InvalidScenario(diagnostics=diagnostics):
            print("\n\n".join(render_text(found, colour=colour) for found in diagnostics), file=sys.stderr)
        case InvalidUse(span=Span() as span):
            print(render_text(_at_run(error, span), colour=colour), file=sys.stderr)
        case InvalidUse(help=hint) if hint:
            print(f"error: {error}\n  = help: {hint}", file=sys.stderr)
        case _:
            print(f"error: {error}", file=sys.stderr)


def print_reason(verdict: Verdict) -> None:
    """Print on stderr why a run did not pass, with the text of the scenario that decided, if any did."""
    if verdict.span is not None:
        found = _at_run(InvalidUse(verdict.reason, verdict.span), verdict.span)
        print("\n" + render_text(found, colour=use_colour(sys.stderr)), file=sys.stderr)
    elif verdict.reason:
        print(f"\n{verdict.status.value}: {verdict.reason}", file=sys.stderr)


def _at_run(error: InvalidUse, span: Span) -> Diagnostic:
    """What was found when a scenario was to be run, or ran, as a diagnostic."""
    first, *others = [Label(place, text) for place, text in error.places] or [Label(span, "")]
    return Diagnostic(Severity.ERROR, error.code, str(error), first, tuple(others), help=error.help)


class _Console(Console):
    """A console that falls silent when nobody reads it any more, as after `| head`: the run goes on."""

    def on_broken_pipe(self) -> None:
        self.quiet = True
        # Else Python itself would complain when it flushes stdout at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), self.file.fileno())


class Progress:
    """Prints what happens in a run, as it happens.

    Args:
        file: Where to.
    """

    def __init__(self, file: IO[str]) -> None:
        self._console = _Console(file=file, no_color=not use_colour(file), highlight=False, soft_wrap=True)
        self._running: dict[int, tuple[str, float]] = {}

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
                style = {"warning": "yellow", "error": "red"}.get(record["level"], "")
                self._line(record["t"], style, " ", record["message"])
            case "event" if record["name"] == "contact":
                arguments = record["arguments"]
                self._line(record["t"], "red", "!", f"{arguments['first']} touches {arguments['second']}")

    def _end(self, record: dict[str, Any]) -> None:
        name, started = self._running.pop(record["id"])
        if name == "log":
            return
        mark, style = _MARKS[record["status"]]
        took = record["t"] - started
        self._line(record["t"], style, mark, f"{name}  {record['status']} after {took:.2f} s")

    def _line(self, time: float, style: str, mark: str, text: str) -> None:
        self._console.print(Text.assemble((f"{time:9.3f} s  ", "dim"), (f"{mark} {text}", style)))

    def say(self, text: str) -> None:
        """Print a line."""
        self._console.print(Text(text))

    def verdict(self, verdict: Verdict) -> None:
        """Print the end of a run."""
        line = Text.assemble(
            (verdict.status.value, _STATUS_STYLES[verdict.status]),
            f"  {verdict.scenario} in {verdict.duration:.2f} s of its clock, {verdict.wall_duration:.2f} s real",
        )
        self._console.print()
        self._console.print(line)
        self._coverage([item for item in verdict.coverage if item.grade is not None])

    def _coverage(self, items: Sequence[ItemCoverage]) -> None:
        """Print how much of the goals of coverage was reached."""
        for item in items[:_MAX_ITEMS]:
            reached = f"{item.reached} of {item.total} buckets ({item.grade:.0%})"
            self.say(f"  {item.item}: {reached}" + (f", {item.illegal} illegal" if item.illegal else ""))
        if len(items) > _MAX_ITEMS:
            self.say(f"  and {len(items) - _MAX_ITEMS} more items: `--json` has all of them")
