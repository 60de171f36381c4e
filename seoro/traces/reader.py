"""Reader of traces (JSON Lines), also of killed runs, and filter for their records."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from fnmatch import fnmatchcase
from typing import IO, Any, Final, TypeAlias

MAX_LINE: Final = 64 * 1024 * 1024  # [bytes], longer than any valid record
LATEST: Final = 1e12  # [s], longer than any run, and small enough for computations

Record: TypeAlias = dict[str, Any]
INVALID: Final = object()  # of a line that is not JSON

_BOM: Final = b"\xef\xbb\xbf"
_NUMBER: Final = (int, float)  # `int | float` would be made anew for each record

# Required fields of each kind of record, apart from `seq`, `t` and `kind`.
_FIELDS: Final[dict[str, tuple[tuple[str, type], ...]]] = {
    "run.start": (("scenario", str), ("file", str)),
    "behavior.start": (("id", int), ("type", str), ("name", str), ("path", str), ("source", str)),
    "behavior.end": (("id", int), ("status", str)),
    "event": (("name", str),),
    "variable": (("path", str),),
    "log": (("message", str), ("level", str)),
    "cover": (("item", str),),
    "record": (("item", str),),
    "poses": (("time", float), ("entities", dict)),
    "margin": (("check", str), ("value", float), ("source", str)),
    "run.end": (("status", str), ("reason", str)),
}
_UNSEARCHED = frozenset({"seq", "t", "wall", "kind", "cause", "node", "sources", "tree"})
# Field with the path or the name of what a record is about.
_SUBJECTS = {"behavior.start": "path", "event": "name", "variable": "path", "cover": "item", "record": "item"}


@dataclass(frozen=True)
class InvalidRecord:
    """Line that is not a valid record.

    Args:
        line: Line number, from 1.
        reason: Reason.
        is_cut: Whether it is an incomplete last line, of a killed or active run.
    """

    line: int
    reason: str
    is_cut: bool

    def __str__(self) -> str:
        return f"line {self.line}: {self.reason}"


def parse_line(line: bytes) -> object:
    """Parse a line; returns `INVALID` if it is not JSON."""
    try:
        found = json.loads(line if line.startswith(_BOM) else line.decode())
    except (ValueError, RecursionError):
        return INVALID
    return _without_surrogates(found) if b"\\ud" in line.lower() else found


class LineReader:
    """Reads a trace in pieces, which may end anywhere.

    Args:
        parse: Parser, for example a faster one. If it raises `ValueError`, `parse_line` decides.
    """

    def __init__(self, parse: Callable[[bytes], object] = parse_line) -> None:
        self._parse = parse
        self._number = 0
        self._start = 0  # [bytes] of the next line in the trace
        self._pieces: list[bytes] = []  # of an incomplete line
        self._size = 0  # [bytes] of the pieces
        self._omitted = 0  # [bytes] of the incomplete line that are not kept

    def feed(self, data: bytes) -> Iterator[tuple[int, int, Record | InvalidRecord]]:
        """Return the complete lines of a trace: start and end [bytes], and record; empty lines are skipped."""
        *lines, rest = data.split(b"\n")
        omitted = 0
        if lines and self._pieces:
            lines[0] = b"".join((*self._pieces, lines[0]))
            self._pieces.clear()
            omitted, self._size, self._omitted = self._omitted, 0, 0
        if self._size < MAX_LINE:  # of a line that is too long, the beginning is enough
            if rest:
                self._pieces.append(rest)
                self._size += len(rest)
        else:
            self._omitted += len(rest)
        return self._read(lines, omitted, is_cut=False)

    def finish(self) -> Iterator[tuple[int, int, Record | InvalidRecord]]:
        """Return the last line if it has no end, as those of killed runs."""
        line, omitted = b"".join(self._pieces), self._omitted
        self._pieces.clear()
        self._size = self._omitted = 0
        yield from self._read([line], omitted, is_cut=True)
        self._start -= 1  # it has no line break; more may follow if the run was not killed

    def _read(
        self, lines: Sequence[bytes], omitted: int, *, is_cut: bool
    ) -> Iterator[tuple[int, int, Record | InvalidRecord]]:
        parse, start, number = self._parse, self._start, self._number
        for line in lines:
            number += 1
            try:
                found: Any = parse(line)
            except ValueError:
                found = parse_line(line)
            end = start + len(line)
            if len(line) < MAX_LINE:
                reason = _problem(found)
            else:  # it may be the first one only that was not kept as a whole
                reason = f"longer than {MAX_LINE:,} bytes"
                end, omitted = end + omitted, 0
            if not reason:
                yield start, end, found
            elif line.strip():
                yield start, end, InvalidRecord(number, reason, is_cut)
            start = end + 1
        self._start, self._number = start, number


def read_trace(file: IO[bytes]) -> Iterator[Record | InvalidRecord]:
    """Yield the records of a trace in order, with an `InvalidRecord` for each invalid line."""
    reader = LineReader()
    while line := file.readline(MAX_LINE):  # by lines, so that those of an active run are there at once
        for *_, found in reader.feed(line):
            yield found
    for *_, found in reader.finish():
        yield found


def _problem(found: Any) -> str:
    """Return why a parsed line is not a record; empty if it is one."""
    if not isinstance(found, dict):
        return "invalid JSON" if found is INVALID else "not a JSON object"
    time, kind = found.get("t"), found.get("kind")
    if not (isinstance(time, _NUMBER) and isinstance(kind, str)):
        return "not a record: missing `t` or `kind`"
    if not -LATEST <= time <= LATEST:
        return f"time is not between 0 s and {LATEST:g} s"
    if (arguments := found.get("arguments")) is not None and not isinstance(arguments, dict):
        return f"not a record: `arguments` of `{kind}` has the wrong type"
    if (fields := _FIELDS.get(kind)) is not None:
        for name, type_ in fields:
            if not isinstance(found.get(name), type_):
                return f"not a record: `{name}` of `{kind}` is missing or has the wrong type"
    return ""


def _without_surrogates(found: object) -> object:
    """Replace lone surrogates, which JSON allows and UTF-8 does not, by `?`."""
    text = json.dumps(found, ensure_ascii=False).encode("utf-8", "replace")
    return json.loads(text)


def valid_records(found: Iterable[Record | InvalidRecord], problems: list[InvalidRecord]) -> Iterator[Record]:
    """Yield the valid records; add the first hundred invalid ones to `problems`."""
    for item in found:
        if not isinstance(item, InvalidRecord):
            yield item
        elif len(problems) < 100:
            problems.append(item)


def shown(value: object) -> str:
    """Format a value of a record: texts as they are, other values as JSON."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def sample(record: Record) -> str:
    """Format the value of a `cover` or `record` item with its unit."""
    return shown(record.get("value")) + (f" {record['unit']}" if record.get("unit") else "")


@dataclass(frozen=True)
class Filter:
    """Conditions that a record must satisfy, all of them.

    Args:
        kinds: Glob patterns for the kind, of which one must match; empty for any kind.
        paths: Glob patterns for its subject: path of a behavior or variable, name of an event, item of coverage.
        start: Earliest time [s], clock of the run.
        end: Latest time [s].
        text: Regular expression that must match a value.
    """

    kinds: Sequence[str] = ()
    paths: Sequence[str] = ()
    start: float = -math.inf
    end: float = math.inf
    text: re.Pattern[str] | None = None


def wall_time(record: Mapping[str, Any]) -> float:
    """Return the time of the machine of a record [s since the epoch]; that of the run in redacted traces."""
    try:
        return datetime.fromisoformat(record["wall"]).timestamp()
    except (KeyError, TypeError, ValueError):
        return float(record["t"])


def select(records: Iterable[Record], filters: Filter) -> Iterator[Record]:
    """Yield the records that match the filters, in order."""
    running: dict[int, str] = {}  # paths of behaviors
    for record in records:
        kind = record["kind"]
        path = str(record[_SUBJECTS[kind]]) if kind in _SUBJECTS else ""
        if kind == "behavior.start":
            running[record["id"]] = path
        elif kind == "behavior.end":
            path = running.pop(record["id"], "")  # of its start
        if not filters.start <= record["t"] <= filters.end:
            continue
        if filters.kinds and not any(fnmatchcase(kind, pattern) for pattern in filters.kinds):
            continue
        # `[0]` in a path is an index, not a set of characters.
        if filters.paths and not any(fnmatchcase(path, pattern.replace("[", "[[]")) for pattern in filters.paths):
            continue
        if filters.text is not None and not any(filters.text.search(text) for text in (path, *_texts(record))):
            continue
        yield record


def _texts(record: Record) -> Iterator[str]:
    for name, value in record.items():
        if name not in _UNSEARCHED:
            yield str(value)
