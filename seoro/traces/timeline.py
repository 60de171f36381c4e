"""Timeline of a trace: a line per record, indented by nesting.

A behavior that ends at its start has only one line. Lines are produced while records are read; memory holds only
running behaviors.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from seoro.traces.explanation_text import explanation_lines
from seoro.traces.reader import Record, sample, shown

MARKS = {"succeeded": "+", "failed": "x", "cancelled": "-"}
_SHOWN = {
    "behavior.start", "behavior.end", "run.start", "run.end", "log", "event", "variable", "cover", "record",
    "margin",
}  # fmt: skip
_MAX_DEPTH = 30  # of indentation


@dataclass
class _Open:
    """Running behavior."""

    name: str
    source: str
    depth: int
    start: float


@dataclass(frozen=True)
class Line:
    """Line of a timeline.

    Args:
        time: Time [s].
        depth: Level of indentation.
        mark: Symbol: `>` a start, `+ x -` an end, `@` an event, `=` a variable, `#` coverage.
        text: Name or message.
        note: Details: duration, location in the scenario.
        tone: Status of an end, or level of a log; may be empty.
        number: Number of the record.
    """

    time: float
    depth: int
    mark: str
    text: str
    note: str = ""
    tone: str = ""
    number: int = 0

    def __str__(self) -> str:
        text = self.text.replace("\n", "\n" + " " * (15 + 2 * self.depth))
        note = f"  {self.note}" if self.note else ""
        return f"{self.time:10.3f}  {'  ' * self.depth}{self.mark} {text}{note}"


def timeline(records: Iterable[Record], *, is_whole: bool = False) -> Iterator[Line]:
    """Yield the lines of a timeline.

    Args:
        records: Records in order.
        is_whole: Whether to show records of all kinds.
    """
    running: dict[int, _Open] = {}
    held: Record | None = None  # start whose end may follow at once
    depth = 0  # of the next line
    for record in records:
        if not (is_whole or record["kind"] in _SHOWN):
            continue
        is_end = record["kind"] == "behavior.end"
        is_short = held is not None and is_end and (record["id"], record["t"]) == (held["id"], held["t"])
        if held is not None and not is_short:
            yield _numbered(_started(held, running[held["id"]]), held)
        held = None
        if record["kind"] == "behavior.start":
            running[record["id"]] = started = _open(record, running)
            held, depth = record, min(started.depth + 1, _MAX_DEPTH)
        elif is_end:
            unknown = _Open(f"behavior {record['id']}", "", 0, record["t"])
            ended = running.pop(record["id"], unknown)
            yield _numbered(_ended(record, ended, is_short), record)
            depth = ended.depth
        else:
            yield _numbered(_line(record, depth, running), record)
    if held is not None:
        yield _numbered(_started(held, running[held["id"]]), held)


def _numbered(line: Line, record: Record) -> Line:
    number = record.get("seq")
    return replace(line, number=number) if isinstance(number, int) else line


def _open(record: Record, running: dict[int, _Open]) -> _Open:
    around = running.get(record["parent"]) if isinstance(record.get("parent"), int) else None
    depth = min(around.depth + 1, _MAX_DEPTH) if around else 0
    kind, name = record["type"], record["name"]
    text = name if name == kind or kind in ("action", "call") else f"{kind} {name}"
    return _Open(text, record["source"], depth, record["t"])


def _started(record: Record, opened: _Open) -> Line:
    return Line(record["t"], opened.depth, ">", opened.name, opened.source)


def _ended(record: Record, opened: _Open, is_short: bool = False) -> Line:
    status = record["status"]
    took = record["t"] - opened.start
    parts = [
        status if status != "succeeded" else "",
        f"after {took:.3f} s" if took else "",
        str(record.get("reason", "")),
        opened.source if is_short else "",
    ]
    note = ", ".join(part for part in parts if part)
    return Line(record["t"], opened.depth, MARKS.get(status, "?"), opened.name, note, status)


def _line(record: Record, depth: int, running: dict[int, _Open]) -> Line:
    """Make the line of a record other than of behaviors; a log is indented below its behavior."""
    time, kind = record["t"], record["kind"]
    match kind:
        case "run.start":
            text = f"run of `{record['scenario']}` in {record['file']}"
            return Line(time, 0, "|", text, f"seed {record.get('seed')}, {record.get('clock')} clock")
        case "run.end":
            status = record["status"]
            reason = [record["reason"]] if record["reason"] else []
            text = "\n".join([status, *reason, *explanation_lines(record.get("explanation"))])
            return Line(time, 0, "|", text, "", "succeeded" if status == "passed" else status)
        case "log":
            level = record["level"]
            around = [opened.depth for opened in running.values() if opened.source == record.get("source")]
            text = record["message"] if level == "info" else f"{level}: {record['message']}"
            return Line(time, around[-1] + 1 if around else depth, '"', text, "", level)
        case "event":
            arguments = record.get("arguments") or {}
            return Line(time, depth, "@", record["name"], shown(arguments) if arguments else "")
        case "variable":
            return Line(time, depth, "=", record["path"], shown(record.get("value")))
        case "cover" | "record":
            return Line(time, depth, "#", record["item"], sample(record))
        case "margin":
            entity = f" {record['entity']}" if record.get("entity") else ""
            return Line(time, depth, "~", f"margin of {record['check']}{entity}", f"{record['value']:.3g}")
        case _:
            rest = {name: value for name, value in record.items() if name not in ("seq", "t", "wall", "kind")}
            return Line(time, depth, "?", kind, shown(rest))
