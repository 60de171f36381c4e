"""Conversion of traces to Chrome trace events, for Perfetto (ui.perfetto.dev), `chrome://tracing`, speedscope.

The format is that of the document "Trace Event Format": an object with `traceEvents`. Each event has a phase `ph`,
a time `ts` in microseconds, a process (the run) and a thread (a parallel branch).

- Each member of a `parallel` or a `one_of` has its own track, also when it is repeated. All other behaviors are
  slices (`B` and `E`) within their parents.
- Events, logs and samples of coverage are instants (`i`); numeric variables are counters (`C`).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import IO, Any, TypeAlias

from seoro.traces.reader import Record

Event: TypeAlias = dict[str, Any]

_PROCESS = 1
_INSTANTS = 0  # track of events and logs
_REPETITION = re.compile(r"#\d+")


@dataclass(frozen=True)
class _Slice:
    """Running behavior."""

    track: int
    forks: bool  # whether its members have their own tracks


def write_perfetto(records: Iterable[Record], file: IO[str]) -> int:
    """Write a trace as Chrome trace events; return their number."""
    file.write('{"displayTimeUnit": "ms", "traceEvents": [')
    number = 0
    for event in trace_events(records):
        file.write(("," if number else "") + "\n" + json.dumps(event, allow_nan=False))
        number += 1
    file.write("\n]}\n")
    return number


def trace_events(records: Iterable[Record]) -> Iterator[Event]:
    """Yield the events of a trace, in order; running behaviors end with the trace."""
    running: dict[int, _Slice] = {}
    tracks: dict[tuple[int, str], int] = {}
    time = 0.0
    yield _name("thread_name", _INSTANTS, "events and logs")
    for record in records:
        time = max(time, _microseconds(record["t"]))
        match record["kind"]:
            case "run.start":
                yield _name("process_name", _INSTANTS, f"{record['scenario']} ({record['file']})")
            case "behavior.start":
                if (
                    again := running.pop(record["id"], None)
                ) is not None:  # files of two runs, one after the other
                    yield _event("E", time, again.track, args={"status": "not ended"})
                yield from _start(record, time, running, tracks)
            case "behavior.end" if (ended := running.pop(record["id"], None)) is not None:
                details = {"status": record["status"], "reason": record.get("reason", "")}
                yield _event("E", time, ended.track, args=details)
            case _:
                yield from _instant(record, time)
    for unfinished in reversed(running.values()):
        yield _event("E", time, unfinished.track, args={"status": "not ended"})


def _start(
    record: Record, time: float, running: dict[int, _Slice], tracks: dict[tuple[int, str], int]
) -> Iterator[Event]:
    around = running.get(record["parent"]) if isinstance(record.get("parent"), int) else None
    is_modifier = record["type"] == "modifier"
    if around is None or (around.forks and not is_modifier):
        key = (around.track if around else 0, _REPETITION.sub("", record["path"]))
        if key not in tracks:
            tracks[key] = len(tracks) + 1
            yield _name("thread_name", tracks[key], key[1] if around else "main flow")
            yield _event("M", 0, tracks[key], name="thread_sort_index", args={"sort_index": tracks[key]})
        track = tracks[key]
    else:
        track = around.track
    forks = record["type"] in ("parallel", "one_of") or (is_modifier and around is not None and around.forks)
    running[record["id"]] = _Slice(track, forks)
    details = {name: record[name] for name in ("path", "source", "type")}
    yield _event("B", time, track, name=record["name"], cat=record["type"], args=details)


def _instant(record: Record, time: float) -> Iterator[Event]:
    match record["kind"]:
        case "event":
            details = {"arguments": _plain(record.get("arguments") or {})}
            yield _event("i", time, _INSTANTS, name=f"@{record['name']}", cat="event", s="p", args=details)
        case "log":
            details = {"level": record["level"], "source": record.get("source", "")}
            yield _event("i", time, _INSTANTS, name=record["message"], cat="log", s="t", args=details)
        case "variable" if _is_number(record.get("value")):
            yield _event("C", time, _INSTANTS, name=record["path"], args={"value": float(record["value"])})
        case "variable" | "cover" | "record":
            name = record["path"] if record["kind"] == "variable" else record["item"]
            details = {"value": _plain(record.get("value")), "unit": record.get("unit") or ""}
            yield _event("i", time, _INSTANTS, name=name, cat=record["kind"], s="t", args=details)
        case "run.end":
            details = {name: record.get(name, "") for name in ("status", "reason", "source")}
            yield _event("i", time, _INSTANTS, name=f"run {record['status']}", cat="run", s="g", args=details)


def _event(phase: str, time: float, track: int, **fields: Any) -> Event:
    return {"ph": phase, "ts": time, "pid": _PROCESS, "tid": track, **fields}


def _name(what: str, track: int, name: str) -> Event:
    return _event("M", 0, track, name=what, args={"name": name})


def _microseconds(time: float) -> float:
    return round(time * 1e6, 3)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _plain(value: Any) -> Any:
    """Replace NaN and infinity, which traces of other writers may have, by texts."""
    match value:
        case float() if not math.isfinite(value):
            return str(value)
        case dict():
            return {name: _plain(part) for name, part in value.items()}
        case list():
            return [_plain(part) for part in value]
        case _:
            return value
