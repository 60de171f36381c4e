"""Goals that a bridge has sent, and that may be taken later: its guard has to know that there are such."""

from __future__ import annotations

from collections.abc import Callable


class Unanswered:
    """How many goals there are of which no server has said yet whether it takes them.

    Attributes:
        when_changed: Called before the first of them is sent, and when there is none any more.
    """

    def __init__(self) -> None:
        self._count = 0
        self.when_changed: Callable[[], None] = lambda: None

    @property
    def is_any(self) -> bool:
        """Whether there is one."""
        return self._count > 0

    def begin(self) -> None:
        """One is about to be sent."""
        self._count += 1
        if self._count == 1:
            self.when_changed()

    def end(self) -> None:
        """One has its answer, or is not waited for any more."""
        self._count -= 1
        if self._count == 0:
            self.when_changed()
