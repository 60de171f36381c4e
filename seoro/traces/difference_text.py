"""Text of the first difference of two runs."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.traces.difference import Difference, Side
from seoro.traces.reader import Record
from seoro.traces.timeline import MARKS, timeline


def common_line(difference: Difference | None) -> str:
    """Return how long the runs are equal."""
    if difference is None:
        return "equal: everything happened at the same times"
    if difference.common is None:
        return "the runs differ from the start"
    return f"equal until {difference.common:.3f} s, then:"


def side_lines(side: Side) -> Iterator[str]:
    """Yield lines about the records that the other run lacks."""
    if side.time is None:
        yield "nothing: the run had ended"
    elif not side.records:
        yield "nothing"
    yield from map(record_line, side.records)


def record_line(record: Record) -> str:
    """Format a record in a line."""
    if record["kind"] == "behavior.end":
        reason = f": {record['reason']}" if record.get("reason") else ""
        return f"{MARKS.get(record['status'], '?')} {record['path']} {record['status']}{reason}"
    shown = next(timeline([record], is_whole=True), None)
    return record["kind"] if shown is None else f"{shown.mark} {shown.text} {shown.note}".rstrip()
