"""Text of the reason why a run did not pass: with lines of the scenario, and the activities at that instant."""

from __future__ import annotations

import textwrap
import traceback
from collections.abc import Iterator
from typing import TYPE_CHECKING

from seoro.lang.source import Span
from seoro.runtime.explanation import Activity, Emitter, Explanation, Kind, Reading
from seoro.runtime.verdict import RunStatus, Verdict
from seoro.text.printable import printable

if TYPE_CHECKING:
    from seoro.lang.diagnostic import Label

_STYLES = {
    RunStatus.FAILED: "31;1",
    RunStatus.ERROR: "35;1",
    RunStatus.CANCELLED: "33;1",
    RunStatus.PASSED: "32;1",
}
_VERBS = {Kind.WAITS: "waiting", Kind.RUNS: "running", Kind.HOLDS: "held"}


def reason_text(verdict: Verdict, colour: bool = False, width: int | None = None) -> str:
    """Format the reason of a verdict; empty for a run that passed.

    Args:
        verdict: Verdict of the run.
        colour: Whether to use ANSI colours.
        width: Width of the terminal, to wrap lines; None for long lines.
    """
    if not verdict.reason:
        return ""
    status = verdict.status.value
    head = f"\x1b[{_STYLES[verdict.status]}m{status}\x1b[0m" if colour else status
    lines = [*_wrap(f"{head}: {printable(verdict.reason)}", "", width)]
    labels = _labels(verdict)
    gutter = " "
    if labels:
        gutter = " " * (len(str(max(label.span.line for label in labels))) + 1)
        lines.append(_marked(labels, colour))
    mark = "\x1b[34;1m=\x1b[0m" if colour else "="
    for first, *rest in _notes(verdict.explanation) if verdict.explanation else ():
        lines += _wrap(f"{gutter}{mark} {printable(first)}", gutter + "  ", width)
        for line in rest:
            lines += _wrap(f"{gutter}  {printable(line)}", gutter + "    ", width)
    return "\n".join(lines)


def fault_text(fault: Exception) -> str:
    """Format the location of an exception in an action's code that ended a run."""
    frames = traceback.extract_tb(fault.__traceback__)
    where = f"raised in {frames[-1].filename}:{frames[-1].lineno}, `{frames[-1].name}`; " if frames else ""
    return f"  = {where}`--debug` shows the traceback"


def _marked(labels: list[Label], colour: bool) -> str:
    """Format the lines of the scenario with labels."""
    from seoro.lang.diagnostic import Diagnostic, Severity  # noqa: PLC0415 - for runs that did not pass
    from seoro.lang.render import render_text  # noqa: PLC0415 - the same

    found = Diagnostic(Severity.ERROR, "", "", labels[0], tuple(labels[1:]))
    return render_text(found, colour=colour).partition("\n")[2]


def _labels(verdict: Verdict) -> list[Label]:
    """Return labels for the deciding place, then for awaited events, and for their emitters."""
    from seoro.lang.diagnostic import Label  # noqa: PLC0415 - for runs that did not pass

    texts: dict[Span, str] = {} if verdict.span is None else {verdict.span: ""}
    for activity in verdict.explanation.activities if verdict.explanation else ():
        since = f"{_VERBS[activity.kind]} since {activity.ongoing.since:.3f} s"
        texts[activity.ongoing.span] = texts.get(activity.ongoing.span) or since
        for emitter in activity.emitters:
            reached = "not reached" if emitter.time is None else f"was at {emitter.time:.3f} s"
            texts.setdefault(emitter.span, reached)
    return [Label(span, text) for span, text in texts.items()]


def _notes(explanation: Explanation) -> Iterator[list[str]]:
    """Yield paragraphs as lists of lines."""
    if explanation.path:
        yield [f"at {explanation.time:.3f} s in {explanation.path}", *map(_reading, explanation.readings)]
    for activity in explanation.activities:
        yield activity_lines(activity)
    if explanation.more:
        yield [f"and {explanation.more} more activities"]


def activity_lines(activity: Activity) -> list[str]:
    """Format an activity: what runs or waits since when, the values that count, and who would end it."""
    ongoing = activity.ongoing
    due = f", until {activity.due:.3f} s" if activity.due is not None else ""
    lines = [f"{_VERBS[activity.kind]} since {ongoing.since:.3f} s{due}: `{ongoing.text}` ({ongoing.span})"]
    lines += map(_reading, activity.readings)
    lines += [_emitter(emitter, ongoing.since) for emitter in activity.emitters]
    if activity.event and not activity.emitters:
        lines.append(f"no `emit` of `{activity.event}` in the scenario")
    return lines


def _emitter(emitter: Emitter, since: float) -> str:
    place = f"`{emitter.text}` ({emitter.span})"
    if emitter.time is not None:
        before = ", before this wait" if emitter.time <= since else ""
        return f"{place} was reached at {emitter.time:.3f} s{before}"
    after = emitter.after
    on = f": `{after.text}` running since {after.since:.3f} s ({after.span})" if after is not None else ""
    return f"{place} was not reached{on}"


def _reading(reading: Reading) -> str:
    if reading.error:
        return f"{reading.text} has no value: {reading.error}"
    return f"{reading.text} = {reading.shown}"


def _wrap(text: str, indent: str, width: int | None) -> list[str]:
    if width is None:
        return [text]
    return textwrap.wrap(
        text,
        max(width, 30),
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
        replace_whitespace=False,
        drop_whitespace=True,
    ) or [text]
