"""The fields of an instance while they get their values: what is missing is computed when it is asked for."""

from __future__ import annotations

from collections.abc import Callable

from seoro.runtime.values import Value

Compute = Callable[[str], Value]


class Fields(dict[str, Value]):
    """Values by name.

    `compute` gives the value of a field that has none yet, or raises `KeyError`; it is None once all are there.
    """

    compute: Compute | None = None

    def __missing__(self, name: str) -> Value:
        if self.compute is None:
            raise KeyError(name)
        return self.compute(name)
