"""Sets of the numbers of runs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

_BITS: Final = 12  # of a number within its page


class Numbers:
    """Set of numbers from 0, with a bit for each: a million take 150 kB, where a set takes 64 MB."""

    def __init__(self) -> None:
        self._pages: dict[int, bytearray] = {}

    def __contains__(self, number: object) -> bool:
        assert isinstance(number, int)
        page = self._pages.get(number >> _BITS)
        return page is not None and bool(page[(number >> 3) & _LAST] & 1 << (number & 7))

    def add(self, number: int) -> bool:
        """Add a number; returns whether it is new."""
        page = self._pages.get(number >> _BITS)
        if page is None:
            page = self._pages[number >> _BITS] = bytearray(1 << (_BITS - 3))
        at, bit = (number >> 3) & _LAST, 1 << (number & 7)
        is_new = not page[at] & bit
        page[at] |= bit
        return is_new

    def update(self, numbers: Iterable[int]) -> None:
        """Add several numbers."""
        for number in numbers:
            self.add(number)


_LAST: Final = (1 << (_BITS - 3)) - 1  # of the bytes of a page
