"""The fields of an instance while they get their values: what is missing is computed when it is asked for."""

from __future__ import annotations

from collections.abc import Callable

from seoro.runtime.values import Value

Compute = Callable[[str], Value]


class Fields(dict[str, Value]):
    """Values by name.

    Args:
        compute: Gives the value of a field that has none yet, or raises `KeyError`; None once all are there.
    """

    def __init__(self, compute: Compute | None = None) -> None:
        super().__init__()
        self.compute = compute

    def __missing__(self, name: str) -> Value:
        if self.compute is None:
            raise KeyError(name)
        return self.compute(name)
