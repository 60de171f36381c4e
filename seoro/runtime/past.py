"""Causal pasts: the occurrences that a flow of control, or who listens for it, must not see (again) (7.6.2.5).

An occurrence belongs to an instant, so that of an earlier one nothing has to be known.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(eq=False)
class Past:
    """The numbers of what was emitted and consumed in one instant."""

    _numbers: set[int] = field(default_factory=set)
    _instant: int = -1

    def of(self, instant: int) -> set[int]:
        """What is past of an instant, to read and to add to; what was past of others is forgotten."""
        if self._instant != instant:
            self._numbers, self._instant = set(), instant
        return self._numbers

    def fork(self) -> Past:
        """The same, for one who goes on beside."""
        return Past(set(self._numbers), self._instant)

    def join(self, other: Past, instant: int) -> None:
        """Take in what another had in an instant."""
        self.of(instant).update(other.of(instant))
