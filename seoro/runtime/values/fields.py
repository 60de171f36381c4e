"""Fields of an instance while its values are chosen: missing values are computed on access."""

from __future__ import annotations

import sys
from collections.abc import Callable

from seoro.runtime.values.values import Value

Compute = Callable[[str], Value]

_FRAMES = 12  # of Python's stack per value that refers to another one
_MAX_ROW = 4000  # longest chain of values that refer to each other


class Fields(dict[str, Value]):
    """Values by name.

    `compute` returns a missing value, or raises `KeyError`; None when all values are set.
    """

    compute: Compute | None = None

    def __missing__(self, name: str) -> Value:
        if self.compute is None:
            raise KeyError(name)
        return self.compute(name)


def make_room(count: int) -> None:
    """Raise Python's recursion limit for a chain of values that refer to each other.

    The limit belongs to the process. It is never lowered, since another thread may need it.

    Args:
        count: Number of values.
    """
    needed = 1000 + _FRAMES * min(count, _MAX_ROW)
    if count > _FRAMES and needed > sys.getrecursionlimit():
        sys.setrecursionlimit(needed)
