"""A trace as Chrome trace events, which Perfetto (ui.perfetto.dev), `chrome://tracing` and speedscope show.

The format is that of the document "Trace Event Format": an object whose `traceEvents` have a phase `ph`, a time
`ts` in microseconds, and the numbers of a process and a thread, which stand for the run and a flow of control.

- Each member of a `parallel` or a `one_of` has a track of its own, the same again when it is repeated; all other
  behaviors are slices (`B` and `E`) within what they are part of.
- Events, logs and samples of coverage are instants (`i`); numbers in variables are counters (`C`).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import IO, Any, TypeAlias

from seoro.traces.read import Record

Event: TypeAlias = dict[str, Any]

_PROCESS = 1
_HAPPENINGS = 0  # the track of what belongs to no flow
_REPETITION = re.compile(r"#\d+")


@dataclass(frozen=True)
class _Slice:
    """A behavior that runs."""

    track: int
    forks: bool  # whether what it consists of has tracks of its own


def write_perfetto(records: Iterable[Record], file: IO[str]) -> int:
    """Write a trace in that format, event by event; returns their number."""
    file.write('{"displayTimeUnit": "ms", "traceEvents": [')
    number = 0
    for event in trace_events(records):
        file.write(("," if number else "") + "\n" + json.dumps(event, allow_nan=False))
        number += 1
    file.write("\n]}\n")
    return number


def trace_events(records: Iterable[Record]) -> Iterator[Event]:
    """The events of a trace, in the order of its records; a behavior that has not ended ends with the trace."""
    running: dict[int, _Slice] = {}
    tracks: dict[tuple[int, str], int] = {}
    time = 0.0
    yield _name("thread_name", _HAPPENINGS, "events and logs")
    for record in records:
        time = max(time, _microseconds(record["t"]))
        match record["kind"]:
            case "run.start":
                yield _name("process_name", _HAPPENINGS, f"{record['scenario']} ({record['file']})")
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
                yield from _happening(record, time)
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


def _happening(record: Record, time: float) -> Iterator[Event]:
    match record["kind"]:
        case "event":
            details = {"arguments": _plain(record.get("arguments") or {})}
            yield _event("i", time, _HAPPENINGS, name=f"@{record['name']}", cat="event", s="p", args=details)
        case "log":
            details = {"level": record["level"], "source": record.get("source", "")}
            yield _event("i", time, _HAPPENINGS, name=record["message"], cat="log", s="t", args=details)
        case "variable" if _is_number(record.get("value")):
            yield _event("C", time, _HAPPENINGS, name=record["path"], args={"value": float(record["value"])})
        case "variable" | "cover" | "record":
            name = record["path"] if record["kind"] == "variable" else record["item"]
            details = {"value": _plain(record.get("value")), "unit": record.get("unit") or ""}
            yield _event("i", time, _HAPPENINGS, name=name, cat=record["kind"], s="t", args=details)
        case "run.end":
            details = {name: record.get(name, "") for name in ("status", "reason", "source")}
            yield _event("i", time, _HAPPENINGS, name=f"run {record['status']}", cat="run", s="g", args=details)


def _event(phase: str, time: float, track: int, **fields: Any) -> Event:
    return {"ph": phase, "ts": time, "pid": _PROCESS, "tid": track, **fields}


def _name(what: str, track: int, name: str) -> Event:
    return _event("M", 0, track, name=what, args={"name": name})


def _microseconds(time: float) -> float:
    return round(time * 1e6, 3)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _plain(value: Any) -> Any:
    """Values as any JSON parser takes them; traces of other writers may have NaN."""
    match value:
        case float() if not math.isfinite(value):
            return str(value)
        case dict():
            return {name: _plain(part) for name, part in value.items()}
        case list():
            return [_plain(part) for part in value]
        case _:
            return value
