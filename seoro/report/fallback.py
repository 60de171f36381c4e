"""Content of a report without JavaScript: verdict, reason, behaviors and logs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from typing import Final

from seoro.report.reading import Reading
from seoro.traces.explanation_text import explanation_lines

MOST_ROWS: Final = 1_000
_UNSAFE: Final = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
_WORDS: Final = {"passed": "Passed", "failed": "Failed", "error": "Error", "cancelled": "Cancelled"}


def safe(text: object) -> str:
    """Return a text for HTML: markup is escaped; controls, also of the direction of text, are replaced."""
    return escape(_UNSAFE.sub("\ufffd", str(text)))


def verdict_word(reading: Reading) -> str:
    """Return the verdict in one word."""
    if reading.end is None:
        return "Not ended"
    return _WORDS.get(reading.end["status"], "Unknown")


def content(reading: Reading, command: str) -> Iterator[str]:
    """Yield the parts of the content."""
    start, end = reading.start or {}, reading.end or {}
    yield f"<h1>{safe(verdict_word(reading))}: {safe(start.get('scenario', 'run'))}</h1>"
    if end.get("reason"):
        source = f" ({safe(end['source'])})" if end.get("source") else ""
        yield f"<p>{safe(end['reason'])}{source}</p>"
    yield f"<p>{safe(start.get('file', ''))}, seed {safe(start.get('seed', 'unknown'))}, {reading.time:.3f} s</p>"
    yield from _list("At the end", explanation_lines(end.get("explanation")))
    if command:
        yield f"<h2>Repeat</h2><pre>{safe(command)}</pre>"
    yield from _list("Behaviors", _behaviors(reading))
    if reading.logs:
        yield from _list("Log", (f"{log['t']:.3f} s {log['level']}: {log['message']}" for log in reading.logs))
        if (more := reading.kinds["log"] - len(reading.logs)) > 0:
            yield f"<p>{more:,} further messages are in the trace.</p>"


def _list(title: str, lines: Iterator[str]) -> Iterator[str]:
    first = next(lines, None)
    if first is None:
        return
    yield f"<h2>{safe(title)}</h2><pre>{safe(first)}"
    for line in lines:
        yield f"\n{safe(line)}"
    yield "</pre>"


def _behaviors(reading: Reading) -> Iterator[str]:
    depths: list[int] = []
    totals = reading.behaviors.totals()
    for number, row in enumerate(reading.behaviors.rows):
        depths.append(0 if row.parent < 0 else depths[row.parent] + 1)
        if number < MOST_ROWS:
            counts = ", ".join(f"{count} {status}" for status, count in totals[number].items())
            yield f"{'  ' * min(depths[number], 40)}{row.name} ({row.source}): {counts}"
    if (more := len(depths) - MOST_ROWS) > 0:
        yield f"{more:,} further behaviors"
