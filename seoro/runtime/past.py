"""Causal pasts: the occurrences that a flow of control, or who listens for it, must not see (again) (7.6.2.5).

An occurrence belongs to an instant, so that of an earlier one nothing has to be known.
"""

from __future__ import annotations


class Past:
    """The numbers of what was emitted and consumed in one instant."""

    __slots__ = ("_instant", "_numbers")

    def __init__(self) -> None:
        self._numbers: set[int] | None = None  # None as long as there is nothing, as mostly
        self._instant = -1

    def add(self, number: int, instant: int) -> None:
        """Something of an instant is past; what was past of others is forgotten."""
        if self._instant != instant or self._numbers is None:
            self._numbers, self._instant = {number}, instant
        else:
            self._numbers.add(number)

    def has(self, number: int, instant: int) -> bool:
        """Whether something of an instant is past."""
        return self._instant == instant and self._numbers is not None and number in self._numbers

    def fork(self) -> Past:
        """The same, for one who goes on beside."""
        other = Past()
        if self._numbers:
            other._numbers, other._instant = set(self._numbers), self._instant
        return other

    def join(self, other: Past, instant: int) -> None:
        """Take in what another had in an instant."""
        if other._instant == instant and other._numbers:
            if self._instant != instant or self._numbers is None:
                self._numbers, self._instant = set(), instant
            self._numbers |= other._numbers
