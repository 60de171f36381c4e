"""Numbers over time: variables, and numbers that events carry."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass, field
from typing import Any, Final

from seoro.report.columns import Packed, reals
from seoro.traces.reader import Record

MOST: Final = 300  # series of a report
_NUMBER: Final = (int, float)
_LONGEST: Final = 300  # [characters] of a name


@dataclass
class Series:
    """A number over time.

    Args:
        kind: `variable`, `event`, or `entity`.
        name: Name for people.
        unit: Unit; empty if unknown or 1.
        times: Times of the run [s].
        values: Values at these times.
    """

    kind: str
    name: str
    unit: str = ""
    times: array[float] = field(default_factory=reals)
    values: array[float] = field(default_factory=reals)


class AllSeries:
    """All series of a run.

    Attributes:
        omitted: Number of values of series beyond the limit.
    """

    def __init__(self) -> None:
        self._series: dict[tuple[str, str], Series] = {}
        self.omitted = 0

    def variable(self, record: Record, seq: int) -> None:
        """Add the change of a variable; other values than numbers are skipped."""
        self.add("variable", record["path"], record["t"], record.get("value"))

    def event(self, record: Record, seq: int) -> None:
        """Add the numbers of an event; texts among its arguments distinguish series, such as names of robots."""
        found = record.get("arguments")
        if not found:
            return
        who = ", ".join(value for value in found.values() if isinstance(value, str) and len(value) < 60)
        name = f"{record['name']} ({who})" if who else record["name"]
        for argument, value in found.items():
            if argument != "time":
                self.add("event", f"{name}: {argument}", record["t"], value)

    def add(self, kind: str, name: str, time: float, value: object, unit: str = "") -> None:
        """Add a value; one that is not a finite number is skipped."""
        if not isinstance(value, _NUMBER) or isinstance(value, bool):
            return
        try:
            found = self._series[kind, name]
        except KeyError:
            if not _is_finite(value):
                return
            if len(self._series) >= MOST:
                self.omitted += 1
                return
            found = self._series[kind, name] = Series(kind, name, unit)
        if _is_finite(value):
            found.times.append(time)
            found.values.append(value)

    def pack(self, packed: Packed) -> list[dict[str, Any]]:
        """Append the columns, and return the descriptions of new series."""
        for number, series in enumerate(self._series.values()):
            packed.add_table(f"series.{number}", [("t", series.times), ("v", series.values)])
        return [
            {"kind": series.kind, "name": series.name[:_LONGEST], "unit": series.unit}
            for series in packed.rest("series", list(self._series.values()))
        ]


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond floats
        return False
