"""Counts of passed and failed runs by the values of a column, in constant memory.

Few values are counted one by one. Many numbers are counted in bins, whose width is a power of ten and grows with
the range of the numbers. So the counts are exact, and nearly the same in any order of the runs.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate, chain
from operator import itemgetter
from typing import Any, Final, TypeAlias, TypeGuard

from seoro.campaign.report.grouping import Bucket, Grouping

MOST_COLUMNS: Final = 200  # of parameters, and of measurements
MOST_VALUES: Final = 12  # counted one by one
MOST_TEXTS: Final = 200  # of a column of texts; more are counted as `OTHERS`
MOST_BINS: Final = 1000
OTHERS: Final = "other values"
_LARGEST: Final = 1e290  # larger numbers are left out, so that no bin overflows
_DIGITS: Final = 15  # of a float
_GUARD: Final = 1e-9  # so that 0.3 is in bin 3 of width 0.1
_NUMBERS: Final = {int, float, bool}
_Value: TypeAlias = int | float | str

Cell: TypeAlias = list[int]  # passed, failed


class Column:
    """Counts of one parameter or measurement.

    Args:
        most_bins: Maximum number of bins.
    """

    def __init__(self, most_bins: int = MOST_BINS) -> None:
        self._most_bins = most_bins
        self._values: dict[Any, Cell] = {}
        self._bins: dict[int, Cell] = {}
        self._exponent = 0  # width of bins is ten to this power
        self._scale: float | None = None  # bins per unit; None while values are counted
        self._first = self._last = 0  # bins in use

    def add(self, values: Sequence[object], failures: Sequence[bool]) -> None:
        """Count values of runs; many at once, since each then costs a fraction of a single one.

        Args:
            values: The values; None for runs without one.
            failures: Whether the runs failed.
        """
        for has_failed in (False, True):
            part = [value for value, failed in zip(values, failures, strict=True) if failed is has_failed]
            self.add_equal(part, has_failed)

    def add_equal(self, values: Sequence[object], has_failed: bool) -> None:
        """Count values of runs that all failed, or all passed.

        Args:
            values: The values; None for runs without one.
            has_failed: Whether the runs failed.
        """
        if not values:
            return
        if self._scale is None:
            self._count(values, has_failed)
        elif _are_numbers(values):
            self._count_in_bins(values, has_failed)
        else:
            self._count([value for value in values if not isinstance(value, int | float)], has_failed)
            numbers = [value for value in values if isinstance(value, int | float) and abs(value) < _LARGEST]
            if numbers:
                self._count_in_bins(numbers, has_failed)

    def _count(self, values: Sequence[object], has_failed: bool) -> None:
        """Count values one by one, and numbers in bins after the first that is one too many."""
        for value, count in _tally(values).items():
            key = _key(value)
            if key is not None:
                if self._scale is None or isinstance(key, str):
                    self._cell_of_value(key)[has_failed] += count
                else:
                    self._cell_of(self._bin(key))[has_failed] += count

    def _count_in_bins(self, numbers: Sequence[float], has_failed: bool) -> None:
        for bound in (min(numbers), max(numbers)):
            self._cell_of(self._bin(bound))  # makes the bins wide enough
        assert self._scale is not None, "numbers are counted in bins"
        scale = self._scale
        for number, count in Counter([math.floor(value * scale + _GUARD) for value in numbers]).items():
            self._cell_of(number)[has_failed] += count

    def grouping(self, most: int) -> Grouping:
        """Return the counts in groups.

        Args:
            most: Maximum number of groups.
        """
        if self._scale is None:
            return Grouping(tuple(self._groups_of_values(most)))
        factor = next(each for each in _factors() if self._last // each - self._first // each < most)
        groups = range(self._first // factor, self._last // factor + 1)
        counts = {group: [0, 0] for group in groups}
        for number, cell in self._bins.items():
            _add(counts[number // factor], cell)
        return Grouping(
            tuple(self._range(group * factor, (group + 1) * factor, cell) for group, cell in counts.items())
        )

    def quantiles(self, shares: Sequence[float]) -> Sequence[float]:
        """Return quantiles of the numbers, to the width of a bin; empty without numbers.

        Args:
            shares: Share of the runs up to each quantile, from 0 to 1, in rising order.
        """
        if self._scale is None:
            counts = [(value, sum(cell)) for value, cell in self._values.items() if is_number(value)]
        else:
            counts = [(self._edge(2 * number + 1) / 2.0, sum(cell)) for number, cell in self._bins.items()]
        counts.sort()
        sums = list(accumulate(count for _, count in counts))
        return [counts[bisect_left(sums, share * sums[-1])][0] for share in shares] if sums else ()

    def is_narrower(self, low: Any, high: Any) -> bool:
        """Return whether some of the values are one of several texts, or within half of the range.

        Args:
            low: Least of the values; None for several texts.
            high: Largest of the values.
        """
        if not is_number(low):
            return low is not None and len(self._values) > 1
        return bool(high - low <= self.extent / 2.0 and 0.0 < self.extent < math.inf)

    @property
    def extent(self) -> float:
        """Difference of the largest and the least number; 0 without numbers."""
        numbers = [value for value in self._values if is_number(value)]
        ends = [self._edge(self._first), self._edge(self._last + 1)] if self._scale is not None else numbers
        return max(ends) - min(ends) if ends else 0.0

    @property
    def _is_numeric(self) -> bool:
        return all(map(is_number, self._values))

    def _groups_of_values(self, most: int) -> Iterator[Bucket]:
        items = sorted(self._values.items(), key=lambda item: -sum(item[1]))
        rest = [cell for _, cell in items[most - 1 :]] if len(items) > most else []
        shown = items[: most - 1] if rest else items
        if self._is_numeric:
            shown = sorted(shown)
        for value, cell in shown:
            yield Bucket(text_of(value), cell[0], cell[1], exact=value)
        if rest:
            yield Bucket(OTHERS, sum(cell[0] for cell in rest), sum(cell[1] for cell in rest))

    def _cell_of_value(self, value: float | str) -> Cell:
        cell = self._values.get(value)
        if cell is not None:
            return cell
        if isinstance(value, int | float) and len(self._values) >= MOST_VALUES and self._is_numeric:
            self._use_bins()
            return self._cell_of(self._bin(value))
        return self._values.setdefault(value if len(self._values) < MOST_TEXTS else OTHERS, [0, 0])

    def _use_bins(self) -> None:
        low, high = min(self._values), max(self._values)
        largest = max(abs(low), abs(high))
        self._set_width(max(_power(high - low) - 2, _power(largest) - _DIGITS))
        values, self._values = self._values, {}
        self._first = self._last = self._bin(low)
        for value, cell in values.items():
            _add(self._cell_of(self._bin(value)), cell)

    def _set_width(self, exponent: int) -> None:
        self._exponent, self._scale = exponent, 10.0**-exponent

    def _bin(self, value: float) -> int:
        assert self._scale is not None
        return math.floor(value * self._scale + _GUARD)

    def _range(self, first: int, end: int, cell: Cell) -> Bucket:
        low, high = self._edge(first), self._edge(end)
        return Bucket(f"{low:.6g} to {high:.6g}", cell[0], cell[1], low, high)

    def _edge(self, number: int) -> float:
        return number / 10.0**-self._exponent if self._exponent < 0 else number * 10.0**self._exponent

    def _cell_of(self, number: int) -> Cell:
        cell = self._bins.get(number)
        if cell is not None:
            return cell
        self._first, self._last = min(self._first, number), max(self._last, number)
        while self._last - self._first >= self._most_bins:
            self._widen()
            number //= 10
        return self._bins.setdefault(number, [0, 0])

    def _widen(self) -> None:
        self._set_width(self._exponent + 1)
        self._first //= 10
        self._last //= 10
        bins, self._bins = self._bins, {}
        for number, cell in bins.items():
            _add(self._bins.setdefault(number // 10, [0, 0]), cell)


def count_columns(columns: dict[str, Column], rows: Sequence[Mapping[str, Any]], has_failed: bool) -> None:
    """Count the values of runs that all failed, or all passed.

    Args:
        columns: Counts by name, which are extended.
        rows: Values of each run by name.
        has_failed: Whether the runs failed.
    """
    for name in dict.fromkeys(chain.from_iterable(rows)):
        if name in columns or len(columns) < MOST_COLUMNS:
            columns.setdefault(name, Column()).add_equal(values_of(rows, name), has_failed)


def values_of(rows: Sequence[Mapping[str, Any]], name: str) -> Sequence[object]:
    """Return a value of each row; None if it is missing."""
    try:
        return list(map(itemgetter(name), rows))  # in half of the time
    except KeyError:
        return [row.get(name) for row in rows]


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a number, and no bool."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _are_numbers(values: Sequence[Any]) -> TypeGuard[Sequence[float]]:
    """Return whether all values are numbers that fit into bins."""
    return set(map(type, values)) <= _NUMBERS and min(values) > -_LARGEST and max(values) < _LARGEST


def _tally(values: Sequence[object]) -> Counter[Any]:
    """Count equal values."""
    try:
        return Counter(values)
    except TypeError:  # lists
        return Counter(map(_key, values))


def _key(value: object) -> _Value | None:
    """Return a value to count; None without one."""
    if isinstance(value, str):
        return value
    if isinstance(value, int | float):
        return value if -_LARGEST < value < _LARGEST else None
    return None if value is None else str(value)


def text_of(value: object) -> str:
    """Return a value for people."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _add(cell: Cell, other: Cell) -> None:
    cell[0] += other[0]
    cell[1] += other[1]


def _power(value: float) -> int:
    return math.floor(math.log10(value)) if value > 0.0 else -300


def _factors() -> Iterator[int]:
    """Yield 1, 2, 5, 10, 20, and so on."""
    power = 1
    while True:
        yield from (power, 2 * power, 5 * power)
        power *= 10
