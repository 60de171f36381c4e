"""Replay window: accepts each numbered request of a client that holds robots once, in any order."""

from __future__ import annotations

from typing import Final

from seoro.deferred import dataclass

SIZE: Final = 4096  # accepted numbers below the highest; a process numbers its requests to all servers
_ALL: Final = (1 << SIZE) - 1


class ReplayWindow:
    """Used numbers, for one thread, in constant memory.

    Args:
        floor: Highest number that is rejected from the start.
    """

    def __init__(self, floor: int = 0) -> None:
        self._highest = floor
        self._used = _ALL  # bit n: whether the number `_highest - n` was used

    def accept(self, number: int) -> bool:
        """Mark a number as used; False if it was used before, or is too far below the highest one."""
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
        window: Used numbers of its requests.
    """

    exchange: bytes
    window: ReplayWindow
