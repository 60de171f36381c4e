"""Axes of a campaign: parameters that vary, over listed values or within bounds.

Values are texts in the notation of the scenario, as overrides are.
"""

from __future__ import annotations

import re
from typing import TypeAlias

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

    def levels(self, number: int) -> tuple[str, ...]:
        """Return equidistant values with both bounds; of whole numbers, at most all."""
        if self.is_whole and self.high - self.low < number:
            return tuple(self.text(self.low + step) for step in range(int(self.high - self.low) + 1))
        if number == 1 or self.low == self.high:
            return (self.text(self.low),)
        width = (self.high - self.low) / (number - 1)
        values = [self.low + width * step for step in range(number - 1)] + [self.high]
        return tuple(dict.fromkeys(self.text(round(value) if self.is_whole else value) for value in values))


Axis: TypeAlias = Choices | Interval
"""Parameter that varies."""

_NUMBER = re.compile(r"-?[0-9.]+(e[-+]?[0-9]+)?")
_NO_STRUCTURES = Structures()  # numbers need none
