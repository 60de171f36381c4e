"""Text of the summary of a trace."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from seoro.traces.explanation_text import explanation_lines
from seoro.traces.summary import Ended, Summary

_MOST = 10  # lines of a section


def summary_lines(summary: Summary) -> Iterator[str]:
    """Yield the lines of a summary."""
    yield from _verdict(summary)
    yield from _ended("slowest", summary.slowest)
    yield from _ended("failed", summary.failed)
    yield from _ended("cancelled", summary.cancelled)
    yield from _ended("unfinished", summary.unfinished)
    yield from _behaviors(summary)
    yield from _section("events", [f"{count:6} x {name}" for name, count in summary.events.most_common()])
    yield from _section(
        "variables at the end", [f"  {name} = {value}" for name, value in summary.variables.items()]
    )
    yield from _section("coverage", [f"  {item}: {_values(values)}" for item, values in summary.coverage.items()])


def _verdict(summary: Summary) -> Iterator[str]:
    start, end = summary.run or {}, summary.end
    status = end["status"] if end else "unfinished"
    records = sum(summary.kinds.values())
    yield f"{status}  {start.get('scenario', '')} in {summary.duration:.3f} s, {records} records"
    if start:
        yield f"  {start['file']}, seed {start.get('seed')}, {start.get('clock')} clock"
    if end and end["reason"]:
        place = f"{end['source']}: " if end.get("source") else ""
        yield f"  {place}{end['reason']}"
        yield from (f"    {line}" for line in explanation_lines(end.get("explanation")))


def _ended(title: str, behaviors: Sequence[Ended]) -> Iterator[str]:
    lines = [
        f"{ended.duration:10.3f} s  {ended.name}, from {ended.start:.3f} s, {ended.source}"
        + (f": {ended.reason}" if ended.reason else "")
        for ended in behaviors
    ]
    yield from _section(title, lines)


def _behaviors(summary: Summary) -> Iterator[str]:
    """Yield repeated behaviors by total time."""
    places = sorted(summary.behaviors.values(), key=lambda place: -place.total)
    lines = [
        f"{place.total:10.3f} s  {place.count} x {place.name}, longest {place.longest:.3f} s, {place.source}"
        for place in places
        if place.total > 0 and place.count > 1
    ]
    yield from _section("repeated, by total time", lines)


def _section(title: str, lines: Sequence[str]) -> Iterator[str]:
    if lines:
        yield f"\n{title}:"
        yield from lines[:_MOST]
        if len(lines) > _MOST:
            yield f"  and {len(lines) - _MOST} more (`--json` lists all)"


def _values(values: dict[str, int]) -> str:
    shown = [value if count == 1 else f"{value} ({count} x)" for value, count in list(values.items())[:_MOST]]
    return ", ".join(shown) + (f", and {len(values) - _MOST} more" if len(values) > _MOST else "")
