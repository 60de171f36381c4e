"""Replay window: each numbered request of a client that holds robots is accepted once, in any order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

SIZE: Final = 4096  # numbers below the highest that may still arrive; a process shares them among all that it asks
_ALL: Final = (1 << SIZE) - 1


class ReplayWindow:
    """Numbers that were used, for one thread; its memory does not grow.

    Args:
        floor: The highest number that is not accepted any more.
    """

    def __init__(self, floor: int = 0) -> None:
        self._highest = floor
        self._used = _ALL  # bit n: whether the number `_highest - n` was used

    def accept(self, number: int) -> bool:
        """Use a number; False if it was used before, or is too far below the highest one."""
        behind = self._highest - number
        if behind < 0:
            self._used = (self._used << min(-behind, SIZE) | 1) & _ALL
            self._highest = number
            return True
        if behind >= SIZE or self._used >> behind & 1:
            return False
        self._used |= 1 << behind
        return True


@dataclass(frozen=True, eq=False)
class HolderKey:
    """Authenticates the requests of a client that holds robots.

    Attributes:
        exchange: Public key of the client (X25519); empty without keys.
        window: Numbers of its requests that were used.
    """

    exchange: bytes
    window: ReplayWindow
