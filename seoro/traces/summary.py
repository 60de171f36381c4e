"""Summary of a trace: verdict, durations, failures, cancellations and coverage.

Durations are added up per source location, so that memory grows with the scenario, not with the run.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from typing import Any, Final

from seoro.traces.reader import InvalidRecord, Record, sample

SLOWEST: Final = 10
MOST_PATHS: Final = 50  # failed, cancelled or unfinished behaviors


@dataclass
class Behaviors:
    """Totals of the behaviors at one source location. Durations are in seconds on the clock of the run."""

    name: str
    type: str
    source: str
    count: int = 0
    total: float = 0.0
    longest: float = 0.0
    succeeded: int = 0
    failed: int = 0
    cancelled: int = 0


@dataclass
class Ended:
    """Single behavior; an unfinished one has an empty status."""

    path: str
    name: str
    source: str
    start: float
    duration: float
    status: str
    reason: str = ""


@dataclass
class Summary:
    """Summary of a trace; `run` and `end` are the records `run.start` and `run.end`, or None."""

    run: Record | None = None
    end: Record | None = None
    duration: float = 0.0
    kinds: Counter[str] = field(default_factory=Counter)
    behaviors: dict[tuple[str, str, str], Behaviors] = field(default_factory=dict)
    slowest: list[Ended] = field(default_factory=list)
    failed: list[Ended] = field(default_factory=list)
    cancelled: list[Ended] = field(default_factory=list)
    unfinished: list[Ended] = field(default_factory=list)
    events: Counter[str] = field(default_factory=Counter)
    variables: dict[str, object] = field(default_factory=dict)
    coverage: dict[str, Counter[str]] = field(default_factory=dict)
    problems: list[InvalidRecord] = field(default_factory=list)

    def plain(self) -> dict[str, Any]:
        """Return the summary as JSON data."""
        places = sorted(self.behaviors.values(), key=lambda place: -place.total)
        end = self.end or {}
        return {
            "status": end.get("status"),
            "reason": end.get("reason"),
            "source": end.get("source"),
            "explanation": end.get("explanation"),
            "run": {name: value for name, value in (self.run or {}).items() if name not in ("seq", "kind")}
            or None,
            "duration": self.duration,
            "records": dict(self.kinds),
            "behaviors": [asdict(place) for place in places],
            "slowest": [asdict(ended) for ended in self.slowest],
            "failed": [asdict(ended) for ended in self.failed],
            "cancelled": [asdict(ended) for ended in self.cancelled],
            "unfinished": [asdict(ended) for ended in self.unfinished],
            "events": dict(self.events),
            "variables": self.variables,
            "coverage": {item: dict(values) for item, values in self.coverage.items()},
            "problems": [str(problem) for problem in self.problems],
        }


def summarise(records: Iterable[Record], problems: list[InvalidRecord]) -> Summary:
    """Summarise a trace; `problems` has the lines that cannot be read, and grows during reading."""
    summary = Summary(problems=problems)
    running: dict[int, Record] = {}
    slowest: list[tuple[float, int, Ended]] = []
    for number, record in enumerate(records):
        summary.kinds[record["kind"]] += 1
        summary.duration = max(summary.duration, record["t"])
        match record["kind"]:
            case "behavior.start":
                running[record["id"]] = record
            case "behavior.end" if (start := running.pop(record["id"], None)) is not None:
                ended = _end(summary, start, record)
                if start["type"] in ("action", "wait"):  # composite behaviors take as long as their members
                    entry = (ended.duration, -number, ended)
                    (heapq.heappush if len(slowest) < SLOWEST else heapq.heappushpop)(slowest, entry)
            case _:
                _count(summary, record)
    summary.slowest = [ended for _, _, ended in sorted(slowest, reverse=True) if ended.duration > 0]
    for start in list(running.values())[:MOST_PATHS]:
        summary.unfinished.append(_ended(start, summary.duration, "", ""))
    return summary


def _end(summary: Summary, start: Record, end: Record) -> Ended:
    """Add the end of a behavior to the totals."""
    ended = _ended(start, end["t"], end["status"], str(end.get("reason", "")))
    key = (start["source"], start["type"], start["name"])
    place = summary.behaviors.setdefault(key, Behaviors(start["name"], start["type"], start["source"]))
    place.count += 1
    place.total += ended.duration
    place.longest = max(place.longest, ended.duration)
    place.succeeded += ended.status == "succeeded"
    place.failed += ended.status == "failed"
    place.cancelled += ended.status == "cancelled"
    listed = {"failed": summary.failed, "cancelled": summary.cancelled}.get(ended.status)
    if listed is not None and len(listed) < MOST_PATHS:
        listed.append(ended)
    return ended


def _ended(start: Record, end: float, status: str, reason: str) -> Ended:
    path, name, source = start["path"], start["name"], start["source"]
    return Ended(path, name, source, start["t"], round(end - start["t"], 9), status, reason)


def _count(summary: Summary, record: Record) -> None:
    match record["kind"]:
        case "run.start":
            summary.run = record
        case "run.end":
            summary.end = record
        case "event":
            summary.events[record["name"]] += 1
        case "variable":
            summary.variables[record["path"]] = record.get("value")
        case "cover" | "record":
            summary.coverage.setdefault(record["item"], Counter())[sample(record)] += 1
