"""Descent of one parameter on its ladder, to a rank at which a run fails, and does not one rank below."""

from __future__ import annotations

from enum import Enum

from seoro.campaign.after.ladders import Ladder


class _Phase(Enum):
    HALVING = "halving"  # of the ranks between two
    ROUNDING = "rounding"  # to the multiple of the step beyond the given value
    CHECKING = "checking"  # the rank below, again
    SETTLED = "settled"


class Descent:
    """Descent of one parameter.

    Its ranks are halved, in coarse steps first. If only the given value fails, the multiple of the step beyond it
    is tried, which has fewer digits; then smaller steps.

    Args:
        ladder: The ladder; its given value fails.
    """

    def __init__(self, ladder: Ladder) -> None:
        self._ladder = ladder
        self._low = 0  # does not fail, as far as known
        self._high = ladder.top  # fails
        self._phase = _Phase.HALVING

    def simplify(self) -> None:
        """Take the simplest value, which fails."""
        self._low = self._high = 0
        self._phase = _Phase.SETTLED

    def reopen(self) -> None:
        """Try one rank below again, since other parameters have changed."""
        if self._high > 1:  # rank 0 is tried by others
            self._phase = _Phase.CHECKING

    def candidate(self) -> str | None:
        """Return the next value to try; None if it is settled."""
        while self._phase is _Phase.HALVING and self._high - self._low <= 1:
            self._next_phase()
        match self._phase:
            case _Phase.HALVING:
                return self._ladder.at(self._middle)
            case _Phase.ROUNDING:
                return self._rounded.last
            case _Phase.CHECKING:
                return self._ladder.at(self._high - 1)
            case _Phase.SETTLED:
                return None

    def accept(self) -> None:
        """Take the candidate, which fails."""
        match self._phase:
            case _Phase.ROUNDING:
                self._ladder, self._phase = self._rounded, _Phase.SETTLED
                self._high = self._ladder.top
            case _Phase.CHECKING:
                self._low, self._high, self._phase = 0, self._high - 1, _Phase.HALVING
            case _:
                self._high = self._middle

    def reject(self) -> None:
        """Leave the candidate, which does not fail."""
        match self._phase:
            case _Phase.ROUNDING:
                self._refine()
            case _Phase.CHECKING:
                self._phase = _Phase.SETTLED
            case _:
                self._low = self._middle

    @property
    def _middle(self) -> int:
        return (self._low + self._high) // 2

    @property
    def _rounded(self) -> Ladder:
        rounded = self._ladder.rounded()
        assert rounded is not None, "it is tried only if there is one"
        return rounded

    def _next_phase(self) -> None:
        """Leave halving, which has come to neighbouring ranks."""
        if self._high < self._ladder.top:
            self._phase = _Phase.SETTLED
        elif self._ladder.rounded() is not None:
            self._phase = _Phase.ROUNDING
        else:
            self._refine()

    def _refine(self) -> None:
        refined = self._ladder.refined()
        if refined is None:
            self._phase = _Phase.SETTLED
        else:
            self._ladder, self._phase = refined, _Phase.HALVING
            self._low, self._high = 0, refined.top
