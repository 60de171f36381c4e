"""Causes of a record: the chain of records that brought it about, back to the start of the run, in sentences."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from seoro.traces.reader import Record, shown

UNKNOWN: Final = -1
_ENDS: Final = {"succeeded": "succeeded", "failed": "failed", "cancelled": "was cancelled"}


_SHOWN_AS_TEXT: Final = ("wait", "emit", "call")  # behaviors without a name of their own
_MAX_TEXT: Final = 80  # characters


class CauseIndex:
    """Causes of all records of a trace, in 8 bytes each.

    Attributes:
        is_whole: Whether the records are numbered without gaps; those of a filtered trace are not.
        end: Number of the record of the end of the run; None in the trace of a killed run.
    """

    def __init__(self, records: Iterable[Record]) -> None:
        self._causes = array("q")
        self._knows_any = False
        self.is_whole = True
        self.end: int | None = None
        for record in records:
            cause = record.get("cause")
            number = len(self._causes)
            if not (isinstance(cause, int) and 0 <= cause < number):
                cause = UNKNOWN
            self._knows_any = self._knows_any or cause != UNKNOWN
            self.is_whole = self.is_whole and record.get("seq") == number
            self._causes.append(cause)
            if record["kind"] == "run.end":
                self.end = number

    def __len__(self) -> int:
        return len(self._causes)

    @property
    def knows_any(self) -> bool:
        """Whether any record has a cause; traces of format 1.0 have none."""
        return self._knows_any

    def chain(self, number: int) -> list[int]:
        """Return the numbers of a record and of its causes, the record first."""
        found = [number]
        while (number := self._causes[number]) != UNKNOWN:
            found.append(number)
        return found


@dataclass(frozen=True)
class Texts:
    """Source texts of a run.

    Args:
        lines: Lines of each file.
    """

    lines: Mapping[str, Sequence[str]]

    @classmethod
    def of(cls, start: Record) -> Texts:
        """Read the texts from a `run.start` record; older traces have none."""
        found: dict[str, Sequence[str]] = {}
        for source in start.get("sources") or ():
            if isinstance(source, dict) and isinstance(source.get("text"), str):
                found[str(source.get("name"))] = source["text"].splitlines()
        return cls(found)

    def line(self, record: Record) -> str:
        """Return the text of a record with `source` and `source_end`, up to the end of its first line."""
        file, line, column = [*record["source"].rsplit(":", 2), "", ""][:3]
        end_line, _, end = str(record.get("source_end", "")).partition(":")
        if not (line.isdecimal() and column.isdecimal() and end.isdecimal()):
            return ""
        number, lines = int(line), self.lines.get(file, ())
        if not 0 < number <= len(lines):
            return ""
        text = lines[number - 1]
        found = text[int(column) - 1 : int(end) - 1 if end_line == line else None].strip()
        return found if len(found) <= _MAX_TEXT else found[: _MAX_TEXT - 1] + "…"


@dataclass(frozen=True)
class Step:
    """A record in a chain of causes.

    Args:
        number: Number of the record.
        time: Its time [s].
        text: Sentence about the record.
        record: The record.
    """

    number: int
    time: float
    text: str
    record: Record

    def __str__(self) -> str:
        return f"{self.time:10.3f}  {self.text}  #{self.number}"


def steps(records: Iterable[Record], chain: list[int]) -> list[Step]:
    """Describe the records of a chain of causes, in its order.

    Args:
        records: All records of the trace, in order.
        chain: Numbers from `CauseIndex.chain`.
    """
    wanted = set(chain)
    cause_of = dict(pairwise(chain))
    found: dict[int, Step] = {}
    texts = Texts({})
    for number, record, start in _with_starts(records):
        if record["kind"] == "run.start":
            texts = Texts.of(record)
        if number in wanted:
            is_own = start is not None and start[0] == cause_of.get(number)
            text = _sentence(record, None if start is None else start[1], texts, is_alone=is_own)
            found[number] = Step(number, record["t"], text, record)
            if len(found) == len(wanted):
                break
    return [found[number] for number in chain]


def _with_starts(records: Iterable[Record]) -> Iterator[tuple[int, Record, tuple[int, Record] | None]]:
    """Yield each record with its number, and the start of the behavior that it belongs to, with its number."""
    running: dict[object, tuple[int, Record]] = {}
    for number, record in enumerate(records):
        match record["kind"]:
            case "behavior.start":
                running[record["id"]] = number, record
                yield number, record, running[record["id"]]
            case "behavior.end":
                yield number, record, running.pop(record["id"], None)
            case "behavior.cancel":
                yield number, record, running.get(record.get("id"))
            case "attempt.start" | "attempt.end":
                yield number, record, running.get(record.get("modifier"))
            case _:
                yield number, record, None


def _sentence(record: Record, start: Record | None, texts: Texts, *, is_alone: bool) -> str:
    """Describe a record.

    Args:
        record: The record.
        start: Start of the behavior that it belongs to, if any.
        texts: Source texts of the run.
        is_alone: Whether the cause of an end is the start of the same behavior.
    """
    who = _behavior(start, texts) if start is not None else f"behavior {record.get('id', record.get('modifier'))}"
    reason = f": {record['reason']}" if record.get("reason") else ""
    match record["kind"]:
        case "run.start":
            return f"the run of `{record['scenario']}` started"
        case "run.end":
            return f"the run ended: {record['status']}{reason}"
        case "behavior.start":
            return f"{who} started"
        case "behavior.end":
            ended = _ENDS.get(record["status"], f"ended: {record['status']}")
            return f"{who} {ended}{_took(record, start) if is_alone and start else ''}{reason}"
        case "behavior.cancel":
            return f"{who} began its clean-up"
        case "attempt.start":
            return f"{who} started an attempt"
        case "attempt.end":
            return f"an attempt of {who} {_ENDS.get(record['status'], record['status'])}{reason}"
        case "event":
            return _event(record)
        case "variable":
            return f"`{record['path']}` became {shown(record.get('value'))}"
        case kind:
            return f"`{kind}` was recorded"


def _took(record: Record, start: Record) -> str:
    took = record["t"] - start["t"]
    return f" by itself, {took:.3f} s after its start" if took else " at once"


def _behavior(start: Record, texts: Texts) -> str:
    text = texts.line(start) if start["type"] in _SHOWN_AS_TEXT else ""
    return f"`{text or start['name']}` ({start['source']})"


def _event(record: Record) -> str:
    if record.get("origin"):
        return f"the {record['origin']} emitted `{record['name']}`"
    if "of" not in record:
        return f"a simulator or robot reported `{record['name']}`"
    return f"event `{record['name']}` occurred"
