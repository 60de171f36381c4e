"""Why a run did not pass, for people: the reason, the lines of the scenario that have to do with it, and what was
going on when it was decided."""

from __future__ import annotations

import textwrap
import traceback
from collections.abc import Iterator

from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.render import render_text
from seoro.lang.source import Span
from seoro.runtime.explanation import Activity, Emitter, Explanation, Kind, Reading
from seoro.runtime.verdict import RunStatus, Verdict
from seoro.terminal_text import printable

_STYLES = {
    RunStatus.FAILED: "31;1",
    RunStatus.ERROR: "35;1",
    RunStatus.CANCELLED: "33;1",
    RunStatus.PASSED: "32;1",
}
_VERBS = {Kind.WAITS: "waits", Kind.RUNS: "runs", Kind.HOLDS: "is held"}


def reason_text(verdict: Verdict, colour: bool = False, width: int | None = None) -> str:
    """Why a run ended as it did; empty for one that passed.

    Args:
        verdict: Of the run.
        colour: Whether to use ANSI colours.
        width: Of the terminal, to break lines there; None to leave them long.
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
        found = Diagnostic(Severity.ERROR, "", "", labels[0], tuple(labels[1:]))
        lines.append(render_text(found, colour=colour).partition("\n")[2])
    mark = "\x1b[34;1m=\x1b[0m" if colour else "="
    for first, *rest in _notes(verdict.explanation) if verdict.explanation else ():
        lines += _wrap(f"{gutter}{mark} {printable(first)}", gutter + "  ", width)
        for line in rest:
            lines += _wrap(f"{gutter}  {printable(line)}", gutter + "    ", width)
    return "\n".join(lines)


def fault_text(fault: Exception) -> str:
    """Where the code of an action has raised what ended a run."""
    frames = traceback.extract_tb(fault.__traceback__)
    where = f"raised in {frames[-1].filename}:{frames[-1].lineno}, `{frames[-1].name}`; " if frames else ""
    return f"  = {where}`--debug` shows the traceback"


def _labels(verdict: Verdict) -> list[Label]:
    """What to mark in the text: what decided, then what was waited for, and what would have emitted that."""
    texts: dict[Span, str] = {} if verdict.span is None else {verdict.span: ""}
    for activity in verdict.explanation.activities if verdict.explanation else ():
        since = f"{_VERBS[activity.kind]} since {activity.doing.since:.3f} s"
        texts[activity.doing.span] = texts.get(activity.doing.span) or since
        for emitter in activity.emitters:
            reached = "not reached" if emitter.time is None else f"was at {emitter.time:.3f} s"
            texts.setdefault(emitter.span, reached)
    return [Label(span, text) for span, text in texts.items()]


def _notes(explanation: Explanation) -> Iterator[list[str]]:
    """Paragraphs, each of some lines."""
    if explanation.path:
        yield [f"at {explanation.time:.3f} s in {explanation.path}", *map(_reading, explanation.readings)]
    for activity in explanation.activities:
        yield _activity(activity)
    if explanation.more:
        yield [f"and {explanation.more} more went on"]


def _activity(activity: Activity) -> list[str]:
    doing = activity.doing
    due = f", until {activity.due:.3f} s" if activity.due is not None else ""
    lines = [f"{_VERBS[activity.kind]} since {doing.since:.3f} s{due}: `{doing.text}` ({doing.span})"]
    lines += map(_reading, activity.readings)
    lines += [_emitter(emitter, doing.since) for emitter in activity.emitters]
    if activity.event and not activity.emitters:
        lines.append(f"no `emit` in the scenario makes `{activity.event}` occur")
    return lines


def _emitter(emitter: Emitter, since: float) -> str:
    place = f"`{emitter.text}` ({emitter.span})"
    if emitter.time is not None:
        before = ", before this waited" if emitter.time <= since else ""
        return f"{place} was reached at {emitter.time:.3f} s{before}"
    after = emitter.after
    on = f": `{after.text}` goes on since {after.since:.3f} s ({after.span})" if after is not None else ""
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
