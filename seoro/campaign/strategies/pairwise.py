"""Pairwise testing: each pair of values of two parameters occurs in a run, or each combination of more."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.campaign.strategies.covering import MOST, combinations_of, covering_rows
from seoro.campaign.strategies.grid import LEVELS, listed_axes, values_of
from seoro.errors import UsageError
from seoro.lang.frozen import Value


class Pairwise(Value):
    """Covering array; combinations that constraints exclude are left out.

    Args:
        strength: Number of parameters of a combination.
        levels: Number of values of each axis with bounds, both included; 0 to let each run draw its value.
    """

    strength: int = 2
    levels: int = 0
    name = "pairwise"
    is_learning = False
    is_endless = False
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {
        "strength": "number of parameters of which each combination of values occurs (default: 2)",
        "levels": LEVELS,
    }

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the rows of the array; see `Strategy`."""
        axes = listed_axes(space, self.levels, self.name)
        values = [values_of(axis, self.levels) for axis in axes]
        if self.strength < 2:
            raise UsageError(f"expected a strength from 2, found {self.strength}")
        if self.strength < len(axes):  # else it is a grid, and made lazily
            self._check(list(map(len, values)))
        return self._batches(axes, values, space, seed)

    def _check(self, sizes: Sequence[int]) -> None:
        """Raise `UsageError` if an array would be too large."""
        possible = math.comb(len(sizes), self.strength)
        number = combinations_of(sizes, self.strength) if possible <= MOST else possible
        if number > MOST:
            raise UsageError(
                f"there are more than {MOST:,} combinations of {self.strength} of {len(sizes)} parameters",
                help="choose a smaller `--strength`, fewer `--levels`, or `--strategy random`",
            )

    def _batches(self, axes: Sequence[Axis], values: Sequence[Sequence[str]], space: Space, seed: int) -> Batches:
        def texts(row: Mapping[int, int]) -> dict[str, str]:
            return {axes[index].path: values[index][value] for index, value in sorted(row.items())}

        rows = covering_rows(
            list(map(len, values)), self.strength, seed, lambda row: space.is_feasible(texts(row))
        )
        for row in rows:
            yield [Point(texts({index: value for index, value in enumerate(row) if value is not None}))]
