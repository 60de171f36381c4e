"""Reading the JSON Lines of a trace, one by one, also of a run that was killed."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import IO, Any, Final, TypeAlias

MAX_LINE: Final = 64 * 1024 * 1024  # bytes; no run writes such a record
LATEST: Final = 1e12  # [s]; longer than any run, and small enough for all that is computed from it

Record: TypeAlias = dict[str, Any]

# The fields without which a record of a kind cannot be understood; those of all kinds are `seq`, `t` and `kind`.
_FIELDS: Final[dict[str, dict[str, type]]] = {
    "run.start": {"scenario": str, "file": str},
    "behavior.start": {"id": int, "type": str, "name": str, "path": str, "source": str},
    "behavior.end": {"id": int, "status": str},
    "event": {"name": str},
    "variable": {"path": str},
    "log": {"message": str, "level": str},
    "cover": {"item": str},
    "record": {"item": str},
    "run.end": {"status": str, "reason": str},
}


@dataclass(frozen=True)
class Unreadable:
    """A line that is no record.

    Args:
        line: Its number, from 1.
        reason: What is wrong with it.
        is_cut: Whether it is the last line, and has no end: its run was killed, or is still going on.
    """

    line: int
    reason: str
    is_cut: bool

    def __str__(self) -> str:
        return f"line {self.line}: {self.reason}"


def read_trace(file: IO[bytes]) -> Iterator[Record | Unreadable]:
    """The records of a trace, in their order; in the place of a line that is none, what is wrong with it."""
    number = 0
    while line := file.readline(MAX_LINE):
        number += 1
        has_end = line.endswith(b"\n")
        while not has_end and len(line) == MAX_LINE and (rest := file.readline(MAX_LINE)):
            has_end = rest.endswith(b"\n")
        if not line.strip():
            continue
        found = _record(line)
        if isinstance(found, str):
            yield Unreadable(number, found, is_cut=not has_end)
        else:
            yield found


def _record(line: bytes) -> Record | str:
    """The record of a line, or what is wrong with it."""
    if len(line) == MAX_LINE:
        return f"it is longer than {MAX_LINE:,} bytes"
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return "it is no JSON"
    if not isinstance(found, dict):
        return "it is no JSON object"
    if b"\\ud" in line.lower():
        found = _mended(found)
    time, kind = found.get("t"), found.get("kind")
    if not (isinstance(time, int | float) and isinstance(kind, str)):
        return "it is no record of a trace, which have `t` and `kind`"
    if not abs(time) <= LATEST:
        return f"its time is not between 0 s and {LATEST:g} s"
    if not isinstance(found.get("arguments"), dict | None):
        return f"it is no record of a trace: `arguments` of a `{kind}` is of the wrong type"
    for name, type_ in _FIELDS.get(kind, {}).items():
        if not isinstance(found.get(name), type_):
            return f"it is no record of a trace: `{name}` of a `{kind}` is missing or of the wrong type"
    return dict(found)


def _mended(record: Record) -> Record:
    """The record with `?` for each half of a surrogate pair, which JSON can hold and no text has."""
    text = json.dumps(record, ensure_ascii=False).encode("utf-8", "replace")
    mended: Record = json.loads(text)
    return mended


class Paths:
    """Tells the paths of records: a behavior's end has that of its start."""

    def __init__(self) -> None:
        self._open: dict[int, str] = {}

    def of(self, record: Record) -> str:
        """What the record is about; empty if that has no path. To be called for all records, in their order."""
        match record["kind"]:
            case "behavior.start":
                self._open[record["id"]] = record["path"]
                return str(record["path"])
            case "behavior.end":
                return self._open.pop(record["id"], "")
            case "event":
                return str(record["name"])
            case "variable":
                return str(record["path"])
            case "cover" | "record":
                return str(record["item"])
            case _:
                return ""


def only_records(found: Iterable[Record | Unreadable], problems: list[Unreadable]) -> Iterator[Record]:
    """The records among what was found; the problems are put down, the first hundred."""
    for item in found:
        if not isinstance(item, Unreadable):
            yield item
        elif len(problems) < 100:
            problems.append(item)


def shown(value: object) -> str:
    """A value in a record as people read it: texts as they are, the rest as JSON."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
