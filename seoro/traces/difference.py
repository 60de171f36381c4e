"""First difference of two traces: the instant from which two runs took other courses.

Records of one instant are compared as a set, since their order means nothing. Wall times, numbers of records and
causes, which depend on these numbers, are left out. So are poses: they differ long before anything happens.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Final

from seoro.traces.reader import Record

_LEFT_OUT: Final = frozenset(
    {"seq", "wall", "cause", "id", "parent", "behavior", "by", "modifier", "of", "instance"}
)
_IGNORED: Final = frozenset({"run.start", "scene", "poses", "path", "scan"})
_EXACT: Final = frozenset({"exact", "values"})  # numbers of instances within; `value` and `path` remain
MOST: Final = 20  # records of a side that are kept


@dataclass(frozen=True)
class Side:
    """Records of one run at the first difference that the other run lacks.

    Args:
        time: Time of the instant [s]; None if the run had ended.
        records: The records, at most `MOST`.
    """

    time: float | None
    records: tuple[Record, ...]


@dataclass(frozen=True)
class Difference:
    """First difference of two runs.

    Args:
        common: Time until which the runs are equal [s]; None if their first instants differ.
        first: The first run.
        second: The second run.
    """

    common: float | None
    first: Side
    second: Side


def first_difference(first: Iterable[Record], second: Iterable[Record]) -> Difference | None:
    """Return the first difference of two traces; None for equal ones.

    Args:
        first: Records of a run.
        second: Records of another run.
    """
    common: float | None = None
    ours, theirs = _instants(first), _instants(second)
    while True:
        one, other = next(ours, None), next(theirs, None)
        if one is None and other is None:
            return None
        if one is None or other is None or one[0] != other[0]:
            return Difference(common, _whole(one), _whole(other))
        only_first, only_second = _only(one[1], other[1]), _only(other[1], one[1])
        if only_first or only_second:
            return Difference(common, Side(one[0], only_first[:MOST]), Side(other[0], only_second[:MOST]))
        common = one[0]


def _instants(records: Iterable[Record]) -> Iterator[tuple[float, list[tuple[str, Record]]]]:
    """Yield the instants of a run, each with its records and texts that identify them."""
    wanted = (record for record in _with_paths(records) if record["kind"] not in _IGNORED)
    for time, found in groupby(wanted, key=lambda record: float(record["t"])):
        yield time, [(_identity(record), record) for record in found]


def _with_paths(records: Iterable[Record]) -> Iterator[Record]:
    """Yield the records, ends of behaviors with the path of the behavior."""
    paths: dict[int, str] = {}
    for record in records:
        if record["kind"] == "behavior.start":
            paths[record["id"]] = record["path"]
        yield {**record, "path": paths.pop(record["id"], "")} if record["kind"] == "behavior.end" else record


def _identity(record: Mapping[str, Any]) -> str:
    left = _LEFT_OUT | _EXACT if record["kind"] != "instance" else _LEFT_OUT - {"of"} | _EXACT
    return json.dumps({name: value for name, value in record.items() if name not in left}, sort_keys=True)


def _only(these: list[tuple[str, Record]], others: list[tuple[str, Record]]) -> tuple[Record, ...]:
    """Return the records that the other instant lacks."""
    rest = Counter(identity for identity, _ in others)
    found = []
    for identity, record in these:
        if rest[identity] > 0:
            rest[identity] -= 1
        else:
            found.append(record)
    return tuple(found)


def _whole(instant: tuple[float, list[tuple[str, Record]]] | None) -> Side:
    if instant is None:
        return Side(None, ())
    return Side(instant[0], tuple(record for _, record in instant[1][:MOST]))
