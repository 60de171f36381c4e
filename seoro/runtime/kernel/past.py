"""`CausalPast`: the occurrences that a task or a subscription must not receive (again).

Contract: a task does not receive occurrences that it has sent or received. Those in the past of the task that
started it, and of tasks that it has joined, are excluded too (7.6.2.5). An occurrence belongs to one instant, so a
past keeps one instant only.
"""

from __future__ import annotations


class CausalPast:
    """Numbers of the occurrences of one instant that were sent or received."""

    __slots__ = ("_instant", "_numbers")

    def __init__(self) -> None:
        self._numbers: set[int] | None = None  # None while empty, as in most tasks
        self._instant = -1

    def add(self, number: int, instant: int) -> None:
        """Add an occurrence of an instant; drop those of earlier instants."""
        if self._instant != instant or self._numbers is None:
            self._numbers, self._instant = {number}, instant
        else:
            self._numbers.add(number)

    def contains(self, number: int, instant: int) -> bool:
        """Whether it contains an occurrence of an instant."""
        return self._instant == instant and self._numbers is not None and number in self._numbers

    def fork(self) -> CausalPast:
        """Return a copy, for a started task or for a subscription."""
        other = CausalPast()
        if self._numbers:
            other._numbers, other._instant = set(self._numbers), self._instant
        return other

    def join(self, other: CausalPast) -> None:
        """Add the past of an ended task or of a subscription."""
        if not other._numbers or other._instant < self._instant:
            return
        if other._instant == self._instant and self._numbers is not None:
            self._numbers |= other._numbers
        else:
            self._numbers, self._instant = set(other._numbers), other._instant
