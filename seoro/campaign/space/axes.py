"""Axes of a campaign: parameters that vary, over listed values or within bounds.

Values are texts in the notation of the scenario, as overrides are.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TypeAlias, overload

from seoro.lang.frozen import Value
from seoro.lang.plan import Structures, ValueType
from seoro.lang.source import Span
from seoro.runtime.values.text import value_text

DIGITS = 12  # significant digits of drawn numbers, so that their texts are short


class Choices(Value):
    """Parameter with listed values.

    Args:
        path: Path: `noise`, `robot.noise`, `drive.speed` of the invocation `drive`.
        texts: Its values.
        numbers: The same as numbers in SI base units; None if they have no order.
        span: Place of the list in the text.
    """

    path: str
    texts: tuple[str, ...]
    numbers: tuple[float, ...] | None
    span: Span

    @property
    def is_ascending(self) -> bool:
        """Whether its values are numbers in ascending order, so that neighbours are alike."""
        return self.numbers is not None and list(self.numbers) == sorted(self.numbers)

    def at(self, share: float) -> str:
        """Return the value at a share of the list, from 0 to less than 1."""
        return self.texts[min(int(share * len(self.texts)), len(self.texts) - 1)]


class Interval(Value):
    """Number within bounds, both included.

    Args:
        path: As of `Choices`.
        low: Lower bound [SI base unit].
        high: Upper bound [SI base unit].
        is_whole: Whether its values are whole numbers.
        type: Type of the parameter, for the units of texts.
        span: Place of the range in the text.
    """

    path: str
    low: float
    high: float
    is_whole: bool
    type: ValueType
    span: Span

    def at(self, share: float) -> str:
        """Return the value at a share of the range, from 0 to less than 1; whole numbers are equally likely."""
        if self.is_whole:
            return self.text(min(self.low + int(share * (self.high - self.low + 1)), self.high))
        return self.text(self.low + share * (self.high - self.low))

    def text(self, value: float) -> str:
        """Return a value in the notation of the scenario."""
        rounded = int(value) if self.is_whole else float(f"{value:.{DIGITS}g}")
        return value_text(rounded, self.type, _NO_STRUCTURES)

    def number(self, text: str) -> float:
        """Return the number of a text that `text` has made [SI base unit]."""
        found = _NUMBER.match(text)
        assert found is not None, "it begins with a number"
        return float(found[0])

    def levels(self, number: int) -> Sequence[str]:
        """Return equidistant values with both bounds, made on demand; of whole numbers, at most all."""
        return Levels(self, number)


class Levels(Sequence[str]):
    """Equidistant values of a range with both bounds.

    Args:
        axis: The range.
        number: Their number; fewer if the range has fewer whole numbers, or one value.
    """

    def __init__(self, axis: Interval, number: int) -> None:
        width = axis.high - axis.low
        most = int(width) + 1 if axis.is_whole else number if width > 0.0 else 1
        self._axis, self._number = axis, min(number, most)

    def __len__(self) -> int:
        return self._number

    @overload
    def __getitem__(self, place: int) -> str: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[str]: ...
    def __getitem__(self, place: int | slice) -> str | Sequence[str]:
        if isinstance(place, slice):
            return [self[each] for each in range(*place.indices(self._number))]
        place = range(self._number)[place]
        axis = self._axis
        if place and place == self._number - 1:
            return axis.text(axis.high)
        value = axis.low + (axis.high - axis.low) / max(self._number - 1, 1) * place
        return axis.text(round(value) if axis.is_whole else value)


Axis: TypeAlias = Choices | Interval
"""Parameter that varies."""

_NUMBER = re.compile(r"-?[0-9.]+(e[-+]?[0-9]+)?")
_NO_STRUCTURES = Structures()  # numbers need none
