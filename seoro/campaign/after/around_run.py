"""Base of the strategies around one failed run, which they repeat first."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from typing import ClassVar, TypeAlias

from seoro.campaign.after.same_failure import SameFailure
from seoro.campaign.runs import Point
from seoro.campaign.strategies.contract import Sampling, Told

Repeating: TypeAlias = Generator[Sequence[Point], Sequence[Told], bool]


class AroundRun:
    """Strategy around one failed run.

    Args:
        run: Number of the failed run.
        values: Values of its parameters, by path.
        failure: The failure.

    Attributes:
        values: Present values, first those of the failed run.
        repeated: The failed run, again; None before that.
    """

    is_learning = True
    is_endless = False
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {}

    def __init__(self, run: int, values: Mapping[str, str], failure: SameFailure) -> None:
        self._run = run
        self._failure = failure
        self.values = dict(values)
        self.repeated: Told | None = None

    def _repeat(self) -> Repeating:
        """Repeat the failed run; returns whether it fails the same way."""
        (self.repeated,) = yield [Point(dict(self.values), parent=self._run)]
        return self._failure.holds(self.repeated)
