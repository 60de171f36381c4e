"""Reading a trace, and checking the structure that all traces have.

Records are numbered from 0 without gaps, and time never goes back. Each behavior has one start and one end, within
those of the behavior around it. The run has a start, an end, and one root behavior.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.history import Attempt, History, LoggedEvent, Mark, Node, Record

_REACTIONS = ("emit", "call")
_STATUSES: Final = frozenset({"succeeded", "failed", "cancelled"})
_NUMBER: Final = (int, float)
_FIELDS: Final[dict[str, dict[str, Any]]] = {
    "run.start": {"scenario": str, "parameters": dict, "clock": str},
    "run.end": {"status": str, "duration": _NUMBER},
    "behavior.start": {
        "id": int,
        "parent": (int, type(None)),
        "type": str,
        "name": str,
        "path": str,
        "source": str,
    },
    "behavior.end": {"id": int, "status": str, "reason": str},
    "behavior.cancel": {"id": int},
    "attempt.start": {"modifier": int},
    "attempt.end": {"modifier": int, "status": str},
    "instance": {"behavior": int, "instance": int, "of": str, "values": dict},
    "event": {"name": str, "arguments": dict},
    "variable": {"path": str, "of": int, "field": str},
    "scene": {"time": _NUMBER, "shapes": list, "entities": list},
    "entity": {"time": _NUMBER, "entity": dict},
    "path": {"time": _NUMBER, "entity": str, "points": list},
    "scan": {"time": _NUMBER, "entity": str, "sensor": str, "pose": list, "ranges": list},
    "poses": {"time": _NUMBER, "entities": dict},
}


def read_history(records: Iterable[object], findings: Findings) -> History | None:
    """Read a trace; return None if it has no run.

    Args:
        records: The records.
        findings: Collects violations of the structure.
    """
    read = _Reader(findings)
    for record in records:
        read.take(record)
    return read.finish()


class _Reader:
    """Reads records; malformed ones are reported and skipped."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._history = History()
        self._last = 0.0
        self._next = 0  # expected number of the next record
        self._open: dict[int, Node] = {}
        self._attempts: dict[int, Mark] = {}  # open attempts, by modifier
        self._root: Node | None = None
        self._run: Record | None = None
        self._end: Record | None = None

    def _wrong(self, message: str, *records: int) -> None:
        self._findings.violate(Rule.STRUCTURE, message, None, *records)

    def take(self, record: object) -> None:
        """Read a record."""
        place = len(self._history.records)
        if not isinstance(record, dict) or not _is_stamped(record):
            self._wrong("a record needs `seq`, `t` and `kind`", place)
            return
        if record["seq"] != self._next:
            self._wrong(f"a record has the number {record['seq']}; expected {self._next}", place)
        self._next = record["seq"] + 1
        record = {**record, "seq": place}
        if record["t"] < self._last:
            self._wrong(f"time goes back from {self._last:g} s to {record['t']:g} s", place - 1, place)
            record = {**record, "t": self._last}
        self._last = record["t"]
        if not self._history.times or self._history.times[-1] != self._last:
            self._history.times.append(self._last)
        self._history.records.append(record)
        if self._end is not None:
            self._wrong("a record follows `run.end`", place)
        missing = [
            name
            for name, kinds in _FIELDS.get(record["kind"], {}).items()
            if not isinstance(record.get(name, ...), kinds)
        ]
        cause = record.get("cause", 0)
        if not (isinstance(cause, int) and 0 <= cause < max(place, 1)):
            self._wrong(f"the cause of a record must be an earlier one, found {cause!r}", place)
        if missing:
            self._wrong(f"`{record['kind']}` needs {', '.join(f'`{name}`' for name in missing)}", place)
            return
        self._place(record, Mark(place, self._last))

    def _place(self, record: Record, mark: Mark) -> None:
        match record["kind"]:
            case "run.start":
                if mark.seq != 0:
                    self._wrong("`run.start` is not the first record", mark.seq)
                self._run = self._run or record
            case "run.end":
                self._end = record
            case "behavior.start":
                self._start(record, mark)
            case "behavior.end":
                self._finish_node(record, mark)
            case "behavior.cancel":
                self._cancel(record, mark)
            case "attempt.start" | "attempt.end":
                self._attempt(record, mark)
            case "instance":
                self._instance(record, mark)
            case "event":
                self._add_event(self._history.events, record, record.get("event"), mark)
            case "variable":
                self._add_event(self._history.changes, record, record["field"], mark)
            case _:
                pass  # logs and coverage are not checked

    def _start(self, record: Record, mark: Mark) -> None:
        number, parent = record["id"], record["parent"]
        if number in self._history.nodes:
            self._wrong(f"behavior {number} starts twice", self._history.nodes[number].start.seq, mark.seq)
            return
        around = self._history.nodes.get(parent)
        is_reaction = around is not None and around.end.t == mark.t and record["type"] in _REACTIONS  # to its end
        if parent is not None and parent not in self._open and not is_reaction:
            self._wrong(f"behavior {number} starts in behavior {parent}, which is not running", mark.seq)
        arguments = record.get("arguments") or {}
        if not isinstance(arguments, dict):
            self._wrong(f"invalid `arguments` of behavior {number}; expected an object", mark.seq)
            arguments = {}
        kind, name, path, source = (str(record[name]) for name in ("type", "name", "path", "source"))
        node = Node(number, around, kind, name, path, source, mark, mark, arguments=arguments)
        self._history.nodes[number] = self._open[number] = node
        if around is not None:
            around.children.append(node)
        elif self._root is None:
            self._root = node
        else:
            self._wrong("duplicate root behavior", self._root.start.seq, mark.seq)

    def _finish_node(self, record: Record, mark: Mark) -> None:
        node = self._open.pop(record["id"], None)
        if node is None:
            self._wrong(f"behavior {record['id']} ends, but is not running", mark.seq)
            return
        node.end, node.status, node.reason = mark, record["status"], record["reason"]
        if node.status not in _STATUSES:
            self._wrong(f"invalid end of behavior {node.number}: {node.status!r}", mark.seq)
        running = [child.number for child in node.children if child.number in self._open]
        if running:
            self._wrong(f"behavior {node.number} ends before {running[0]}, which runs in it", mark.seq)
        if node.number in self._attempts:
            self._wrong(f"modifier {node.number} ends before the modified behavior", mark.seq)

    def _cancel(self, record: Record, mark: Mark) -> None:
        node = self._open.get(record["id"])
        if node is None:
            self._wrong(f"behavior {record['id']} is cancelled, but is not running", mark.seq)
        elif node.cancelled is None:
            node.cancelled = mark

    def _attempt(self, record: Record, mark: Mark) -> None:
        number = record["modifier"]
        node, started = self._open.get(number), self._attempts.pop(number, None)
        is_start = record["kind"] == "attempt.start"
        if node is None or is_start is not (started is None):
            self._wrong(f"an attempt of modifier {number} does not start and end in turn", mark.seq)
            return
        if started is None:
            self._attempts[number] = mark
        else:
            node.attempts.append(Attempt(started, mark, record["status"]))

    def _instance(self, record: Record, mark: Mark) -> None:
        node = self._open.get(record["behavior"])
        if node is None:
            self._wrong(f"behavior {record['behavior']} invokes an instance, but is not running", mark.seq)
            return
        node.instances.append(record["instance"])
        node.recorded.append(mark.seq)
        self._history.instances.append(record)

    def _add_event(
        self, where: dict[tuple[int, str], list[LoggedEvent]], record: Record, name: object, mark: Mark
    ) -> None:
        """Add an event of an instance; events of backends belong to none."""
        of = record.get("of")
        if isinstance(of, int) and isinstance(name, str):
            where.setdefault((of, name), []).append(LoggedEvent(mark, of, name, record))

    def finish(self) -> History | None:
        """Return the trace."""
        last = Mark(len(self._history.records) - 1, self._last)
        for node in self._open.values():
            self._wrong(f"behavior {node.number} has no end", node.start.seq)
            node.end = last
        if self._run is None:
            self._wrong("missing `run.start`", 0)
        if self._end is None:
            self._wrong("missing `run.end`", max(last.seq, 0))
        elif self._end["duration"] != self._end["t"]:
            self._wrong("the duration of the run is not the time of its end", self._end["seq"])
        if self._root is None:
            self._wrong("missing root behavior", 0)
        if self._run is None or self._end is None or self._root is None:
            return None
        history = self._history
        history.cleanups = sorted(
            (node.cancelled.t, node.end.t)
            for node in self._history.nodes.values()
            if node.cancelled is not None and node.end.t > node.cancelled.t
        )
        history.run, history.end, history.root = self._run, self._end, self._root
        return history


def _is_stamped(record: Record) -> bool:
    stamps = record.get("seq"), record.get("t"), record.get("kind")
    return isinstance(stamps[0], int) and isinstance(stamps[1], _NUMBER) and isinstance(stamps[2], str)
