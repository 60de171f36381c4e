"""Comparison of traces, without times of the machine."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any, Final

from seoro.campaign.work.watching import lasting_part
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.lang.frozen import Value

MOST_LETTERS: Final = 120  # of a value


class Difference(Value):
    """First difference of two traces.

    Args:
        record: Number of the record, from 0, as `seq` in the traces.
        text: Description of what differs.
    """

    record: int
    text: str


def digest_of(trace: Path) -> str:
    """Return the hash of a trace, as in the column `trace_sha`.

    Raises:
        UsageError: A line of the trace is invalid.
        OSError: It cannot be read.
    """
    found = hashlib.sha256()
    for _, part in _records(trace):
        found.update(part)
    return found.hexdigest()


def clock_of(trace: Path) -> str:
    """Return the clock of a run: `real`, `virtual` or `sim`; empty for an empty trace.

    Raises:
        UsageError: The first line of the trace is invalid.
        OSError: It cannot be read.
    """
    return next((str(record.get("clock", "")) for record, _ in _records(trace)), "")


def first_difference(then: Path, now: Path) -> Difference | None:
    """Return the first difference of two traces; None if they are equal.

    Args:
        then: Earlier trace.
        now: Later trace.

    Raises:
        UsageError: A line of a trace is invalid.
        OSError: A trace cannot be read.
    """
    for number, (earlier, later) in enumerate(zip_longest(_records(then), _records(now))):
        if earlier is None or later is None:
            place = "only in the later trace" if earlier is None else "only in the earlier trace"
            record = later[0] if earlier is None else earlier[0]
            return Difference(number, f"{_name(record)} is {place}")
        if earlier[1] != later[1]:
            return Difference(number, _describe(earlier[0], later[0]))
    return None


def _records(trace: Path) -> Iterator[tuple[dict[str, Any], bytes]]:
    """Yield the records with their lasting parts."""
    with open_input(trace, Kind.TRACE) as file:
        for number, line in enumerate(file, start=1):
            try:
                record = json.loads(line)
                yield record, lasting_part(record, line)
            except (ValueError, KeyError, TypeError, AttributeError) as error:
                raise UsageError(f"{trace}:{number}: invalid record of a trace") from error


def _name(record: dict[str, Any]) -> str:
    path = record.get("path") or record.get("name") or ""
    return f"`{record['kind']}`{f' of `{path}`' if path else ''} at {record['t']} s"


def _describe(then: dict[str, Any], now: dict[str, Any]) -> str:
    if then["kind"] != now["kind"]:
        return f"{_name(then)} before, {_name(now)} now"
    names = [name for name in {**then, **now} if name != "wall" and then.get(name) != now.get(name)]
    parts = (f"`{name}` was {_text(then.get(name))}, is {_text(now.get(name))}" for name in names)
    return f"{_name(now)}: {'; '.join(parts)}"


def _text(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "\u2026"
