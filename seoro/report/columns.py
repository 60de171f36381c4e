"""Tables as bytes that browsers decode quickly and gzip compresses well.

A column is stored as the first bytes of all its values, then the second bytes, and so on. Integers are differences
to the value before. Columns are aligned to nothing: browsers copy each one while they decode it.
"""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Iterable, Sequence
from itertools import chain, islice
from operator import sub
from typing import Final, TypeAlias

Layout: TypeAlias = dict[str, tuple[str, int]]  # type and number of values of each column

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


class Packed:
    """Columns as bytes, with their layout.

    Attributes:
        data: Bytes of all columns.
        layout: Type and number of values of each column, in the order of `data`.
    """

    def __init__(self) -> None:
        self.data = bytearray()
        self.layout: Layout = {}

    def add(self, name: str, column: array[int] | array[float]) -> None:
        """Append a column."""
        code = {"i": "i4", "d": "f8", "B": "u1"}[column.typecode]
        self.layout[name] = (code, len(column))
        self.data += _shuffled(_differences(column) if code == "i4" else column)

    def add_all(self, prefix: str, columns: Sequence[tuple[str, array[int] | array[float]]]) -> None:
        """Append columns with a common prefix of their names."""
        for name, column in columns:
            self.add(f"{prefix}.{name}", column)


def _differences(column: array[int] | array[float]) -> array[int]:
    return array("i", chain(column[:1], map(sub, islice(column, 1, None), column)))


def _shuffled(column: array[int] | array[float]) -> bytes:
    if sys.byteorder == "big":
        column = column[:]
        column.byteswap()
    raw = column.tobytes()
    return b"".join(raw[index :: column.itemsize] for index in range(column.itemsize))
