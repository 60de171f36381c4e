"""The fields of an instance while they get their values: what is missing is computed when it is asked for."""

from __future__ import annotations

import sys
from collections.abc import Callable

from seoro.runtime.values import Value

Compute = Callable[[str], Value]

_FRAMES = 12  # of Python that a value takes which names the next one
_MAX_ROW = 4000  # of values that each name the next one


class Fields(dict[str, Value]):
    """Values by name.

    `compute` gives the value of a field that has none yet, or raises `KeyError`; it is None once all are there.
    """

    compute: Compute | None = None

    def __missing__(self, name: str) -> Value:
        if self.compute is None:
            raise KeyError(name)
        return self.compute(name)


def make_room(count: int) -> None:
    """Raise Python's recursion limit for values of which each may name the next one.

    The limit is one of the process. It is never lowered, since another thread may need it.

    Args:
        count: How many values there are.
    """
    needed = 1000 + _FRAMES * min(count, _MAX_ROW)
    if count > _FRAMES and needed > sys.getrecursionlimit():
        sys.setrecursionlimit(needed)
