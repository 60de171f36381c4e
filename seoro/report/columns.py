"""Tables as bytes that browsers decode quickly and gzip compresses well.

A column is stored as the first bytes of all its values, then the second bytes, and so on. Integers are differences
to the value before. Columns are aligned to nothing: browsers copy each one while they decode it.

Tables only grow. `Packed` can start at the end of an earlier one, and then has new rows only.
"""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain, islice
from operator import sub
from types import MappingProxyType
from typing import Any, Final, TypeAlias, TypeVar

Layout: TypeAlias = dict[str, tuple[str, int]]  # type and number of values of each column
Position: TypeAlias = Mapping[str, object]  # length of each table, and last value of each single value
Column: TypeAlias = "array[int] | array[float]"
T = TypeVar("T")

_CONSTANT: Final = "="  # before the type of a column whose values are all the same: it has only one
BEGIN: Final[Position] = MappingProxyType({})
_UNKNOWN: Final = object()
_LARGEST: Final = 2**30  # so that differences are 32-bit integers, too
_NUMBER: Final = (int, float)
STEP: Final = 1e-4  # [m, rad, m/s, rad/s] of numbers in `scaled`


def integers(values: Iterable[int] = ()) -> array[int]:
    """Make a column of 32-bit integers."""
    return array("i", values)


def reals(values: Iterable[float] = ()) -> array[float]:
    """Make a column of 64-bit floats."""
    return array("d", values)


def small(values: Iterable[int] = ()) -> array[int]:
    """Make a column of bytes."""
    return array("B", values)


def scaled(value: object, step: float = STEP) -> int:
    """Return a number in steps, limited to the range of a column; other values than numbers are 0."""
    if not isinstance(value, _NUMBER) or math.isnan(value):
        return 0
    found = value / step
    return round(found) if -_LARGEST < found < _LARGEST else int(math.copysign(_LARGEST, found))


def scaled_all(values: Sequence[Any]) -> list[int]:
    """Return many numbers in steps, as `scaled`."""
    try:
        found = [round(value / STEP) if value else 0 for value in values]
    except (TypeError, ValueError, OverflowError):  # texts, NaN, infinity
        return [scaled(value) for value in values]
    is_small = not found or (max(found) < _LARGEST and min(found) > -_LARGEST)
    return found if is_small else [scaled(value) for value in values]


class Packed:
    """Columns as bytes, with their layout.

    Args:
        write: Receives the bytes of each column.
        since: Position of an earlier `Packed`; later rows are packed only.

    Attributes:
        layout: Type and number of values of each column, in their order; empty columns are left out.
        position: Position after this one.
    """

    def __init__(self, write: Callable[[bytes], object], since: Position = BEGIN) -> None:
        self.layout: Layout = {}
        self.position: dict[str, object] = {}
        self._write = write
        self._since = since

    def start(self, table: str) -> int:
        """Return the length that a table had at the earlier position."""
        found = self._since.get(table, 0)
        return found if isinstance(found, int) else 0

    def add(self, name: str, column: Column) -> None:
        """Append a whole column."""
        if not column:
            return
        code = {"i": "i4", "d": "f8", "B": "u1"}[column.typecode]
        if _is_constant(column):
            self.layout[name] = (_CONSTANT + code, len(column))
            column = column[:1]
        else:
            self.layout[name] = (code, len(column))
        self._write(_shuffled(_differences(column) if code == "i4" else column))

    def add_table(self, table: str, columns: Sequence[tuple[str, Column]]) -> None:
        """Append the new rows of a table: columns of one length."""
        start, length = self.start(table), len(columns[0][1])
        self.position[table] = length
        if start < length:
            for name, column in columns:
                self.add(f"{table}.{name}", column[start:] if start else column)

    def rest(self, table: str, values: Sequence[T]) -> list[T]:
        """Return the new values of a list."""
        self.position[table] = len(values)
        return list(values[self.start(table) :])

    def has_changed(self, name: str, value: object) -> bool:
        """Return whether a single value differs from that of the earlier position, or has none there."""
        self.position[name] = value
        return self._since.get(name, _UNKNOWN) != value


def _is_constant(column: Column) -> bool:
    first = column[:1].tobytes()
    return len(column) > 1 and column.tobytes() == first * len(column)


def _differences(column: Column) -> array[int]:
    return array("i", chain(column[:1], map(sub, islice(column, 1, None), column)))


def _shuffled(column: Column) -> bytes:
    if sys.byteorder == "big":
        column = column[:]
        column.byteswap()
    raw = column.tobytes()
    return b"".join(raw[index :: column.itemsize] for index in range(column.itemsize))
