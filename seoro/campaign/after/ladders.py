"""Ladders: the values of a parameter between its simplest value and a given one, in order."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from seoro.campaign.space.axes import Axis, Interval
from seoro.lang.frozen import Value

LEVELS: Final = 50  # a step of a range is the largest power of ten with at least so many steps in the range
MOST_FINER: Final = 4  # times that the step of a range is divided by ten
_CLOSE: Final = 1e-9  # of a step


class Ladder(Value):
    """Values from simple to not.

    Args:
        axis: The parameter.
        first: Its simplest value, at rank 0.
        last: The given value, at the last rank.
        listed: Values between the two, if the parameter has listed ones.
        start: Multiple of the step at rank 1, if it has a range.
        count: Number of such multiples between the two.
        step: Distance of two ranks, negative if values fall; 0 without a range.
        finer: Number of times that the step was divided by ten.
    """

    axis: Axis
    first: str
    last: str
    listed: tuple[str, ...] = ()
    start: int = 0
    count: int = 0
    step: float = 0.0
    finer: int = 0

    @property
    def top(self) -> int:
        """Rank of the given value."""
        return len(self.listed) + self.count + 1

    def at(self, rank: int) -> str:
        """Return the value of a rank, from 0 to `top`, in the notation of the scenario."""
        if rank == 0:
            return self.first
        if rank == self.top:
            return self.last
        if isinstance(self.axis, Interval):
            return self.axis.text((self.start + rank - 1) * self.step)
        return self.listed[rank - 1]

    def rounded(self) -> Ladder | None:
        """Return the ladder to the multiple of the step beyond the given value, which has fewer digits.

        Listed values, and given values at the end of a range, have None.
        """
        if not isinstance(self.axis, Interval) or self.step == 0.0:
            return None
        value = (self.start + self.count) * self.step
        is_inside = self.axis.low <= value <= self.axis.high
        text = self.axis.text(value)
        return replace(self, last=text) if is_inside and text != self.last else None

    def refined(self) -> Ladder | None:
        """Return the ladder from the rank before the given value to it, with smaller steps; None without one."""
        if not isinstance(self.axis, Interval) or self.axis.is_whole or self.finer >= MOST_FINER:
            return None
        if _is_multiple(self.axis.number(self.last), self.step):
            return None
        return _of_range(self.axis, self.at(self.top - 1), self.last, abs(self.step) / 10, self.finer + 1)


def step_of(axis: Interval) -> float:
    """Return the step of a range: a power of ten, of which the range has 50 to 500; 1 for whole numbers."""
    if axis.is_whole or axis.high == axis.low:
        return 1.0
    return float(10.0 ** math.floor(math.log10((axis.high - axis.low) / LEVELS)))


def simplest_of(axis: Axis, default: str | None) -> str:
    """Return the simplest value: the default, else the number nearest to zero, else `false` or the first.

    Args:
        axis: The axis.
        default: Its default value; None without one.
    """
    if default is not None:
        return default
    if isinstance(axis, Interval):
        return axis.text(min(max(axis.low, 0.0), axis.high))
    if axis.numbers is not None:
        return min(zip(axis.numbers, axis.texts, strict=True), key=lambda pair: abs(pair[0]))[1]
    return "false" if "false" in axis.texts else axis.texts[0]


def ladder_of(axis: Axis, simplest: str, given: str) -> Ladder:
    """Return the ladder of an axis.

    Args:
        axis: The axis.
        simplest: Its simplest value.
        given: A value of the axis.
    """
    if isinstance(axis, Interval):
        return _of_range(axis, simplest, given, step_of(axis))
    if axis.numbers is not None:
        numbers = dict(zip(axis.texts, axis.numbers, strict=True))
        low, high = sorted((numbers[simplest], numbers[given]))
        between = [text for text, number in numbers.items() if low < number < high]
        between.sort(key=lambda text: abs(numbers[text] - numbers[simplest]))
    else:
        between = [text for text in axis.texts[: axis.texts.index(given)] if text != simplest]
    return Ladder(axis, simplest, given, tuple(between))


def _of_range(axis: Interval, first: str, last: str, step: float, finer: int = 0) -> Ladder:
    """Return the ladder with the multiples of a step between two values."""
    low, high = axis.number(first), axis.number(last)
    signed = step if high >= low else -step
    start = math.floor(low / signed + _CLOSE) + 1
    end = math.ceil(high / signed - _CLOSE) - 1
    return Ladder(axis, first, last, start=start, count=max(end - start + 1, 0), step=signed, finer=finer)


def _is_multiple(value: float, step: float) -> bool:
    return abs(value / step - round(value / step)) < 1e-6
