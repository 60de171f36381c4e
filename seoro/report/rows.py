"""Behaviors of a run as bars in rows: all executions of a behavior of the scenario share a row."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import Any, Final

from seoro.report.columns import Packed, integers, reals, small
from seoro.report.strings import NONE, Strings
from seoro.traces.reader import Record

_REPETITION: Final = re.compile(r"#\d+")
STATUSES: Final = ("running", "succeeded", "failed", "cancelled")
_STATUS_NUMBERS: Final = {status: number for number, status in enumerate(STATUSES)}
MOST_ROWS: Final = 100_000  # further ones share the row of their parent
_LONGEST: Final = 2_000  # [characters] of a label


@dataclass(frozen=True)
class Row:
    """Row of the timeline.

    Args:
        parent: Number of the row around it; -1 for none.
        type: Type of the behavior.
        name: Name of the behavior.
        path: Path without numbers of repetitions.
        source: Place of its start; empty if unknown.
        source_end: Place of its end, `line:column`; empty if unknown.
        node: Number in the static tree; -1 if unknown.
    """

    parent: int
    type: str
    name: str
    path: str
    source: str
    source_end: str
    node: int

    def plain(self) -> list[Any]:
        """Return the row as JSON data."""
        return [self.parent, self.type, self.name, self.path, self.source, self.source_end, self.node]


class Behaviors:
    """All behaviors of a run.

    Args:
        strings: Table for the reasons.

    Attributes:
        rows: The rows, each after its parent.
        omitted: Number of behaviors that share the row of their parent.
    """

    def __init__(self, strings: Strings) -> None:
        self.rows: list[Row] = []
        self.omitted = 0
        self._strings = strings
        self._numbers: dict[tuple[int, str], dict[str, int]] = {}  # of rows: by parent and path around, and name
        self._running: dict[int, int] = {}  # by id: index in the columns
        self._around: tuple[int, str] | None = None  # parent and path around the last behavior
        self._siblings: dict[str, int] = {}  # rows of that path
        self._lost: list[int] = []  # indices that cannot end, since a later behavior has their id
        self._ended = integers()  # indices in the order of the ends
        self._row = integers()
        self._parent = integers()
        self._start = reals()
        self._end = reals()
        self._status = small()
        self._reason = integers()
        self._start_seq = integers()
        self._end_seq = integers()

    def start(self, record: Record, seq: int) -> None:
        """Add a behavior that starts."""
        running, number, around = self._running, record["id"], record.get("parent")
        parent = running.get(around, NONE) if isinstance(around, int) else NONE
        if number in running:
            self._lost.append(running[number])
        running[number] = len(self._row)
        self._row.append(self._row_of(record, NONE if parent == NONE else self._row[parent]))
        self._parent.append(parent)
        self._start.append(record["t"])
        self._start_seq.append(seq)
        self._end.append(0.0)
        self._status.append(0)
        self._reason.append(NONE)
        self._end_seq.append(NONE)

    def end(self, record: Record, seq: int) -> None:
        """End a behavior; one that is not running is skipped."""
        index = self._running.pop(record["id"], None)
        if index is None:
            return
        start, time, status = self._start[index], record["t"], record["status"]
        self._end[index] = time if time > start else start
        self._status[index] = _STATUS_NUMBERS.get(status, 0)
        if reason := record.get("reason"):
            self._reason[index] = self._strings.number(reason)
        self._end_seq[index] = seq
        self._ended.append(index)

    def pack(self, packed: Packed, time: float) -> None:
        """Append the columns of new behaviors, and of older ones that have ended since.

        Args:
            packed: Output.
            time: Latest time [s], where the bars of running behaviors end.
        """
        known, ended = packed.start("behaviors"), packed.start("ended")
        for index in (*self._running.values(), *self._lost):
            self._end[index] = max(time, self._start[index])
        columns = ("row", self._row), ("parent", self._parent), ("start", self._start), ("end", self._end)
        more = ("status", self._status), ("reason", self._reason)
        both = ("startSeq", self._start_seq), ("endSeq", self._end_seq)
        packed.add_table("behaviors", [*columns, *more, *both])
        packed.position["ended"] = len(self._ended)
        indices = integers(index for index in self._ended[ended:] if index < known)
        packed.add("ended.index", indices)
        packed.add("ended.end", reals(self._end[index] for index in indices))
        packed.add("ended.status", small(self._status[index] for index in indices))
        packed.add("ended.reason", integers(self._reason[index] for index in indices))
        packed.add("ended.endSeq", integers(self._end_seq[index] for index in indices))

    def totals(self) -> list[Counter[str]]:
        """Return how often the behaviors of each row ended with each status."""
        found: list[Counter[str]] = [Counter() for _ in self.rows]
        for row, status in zip(self._row, self._status, strict=True):
            found[row][STATUSES[status]] += 1
        return found

    def _row_of(self, record: Record, parent: int) -> int:
        around, slash, last = record["path"].rpartition("/")
        if (parent, around) != self._around:  # siblings often start one after another
            self._around = parent, around
            self._siblings = self._numbers.setdefault((parent, _REPETITION.sub("", around)), {})
        found = self._siblings.get(last)
        if found is not None:
            return found
        last = _REPETITION.sub("", last)
        found = self._siblings.get(last)
        if found is not None:
            return found
        if len(self.rows) >= MOST_ROWS:
            self.omitted += 1
            return max(parent, 0)
        node = record.get("node")
        end = record.get("source_end")
        self._siblings[last] = len(self.rows)
        self.rows.append(
            Row(
                parent,
                record["type"],
                record["name"][:_LONGEST],
                f"{_REPETITION.sub('', around)}{slash}{last}"[:_LONGEST],
                record["source"],
                end if isinstance(end, str) else "",
                node if isinstance(node, int) else NONE,
            )
        )
        return len(self.rows) - 1
