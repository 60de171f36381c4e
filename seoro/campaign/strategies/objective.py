"""Objectives of searches: a column of `runs.csv` that is small, or large, near failures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

from seoro.campaign.runs import End, Row
from seoro.campaign.strategies.contract import Told
from seoro.errors import UsageError
from seoro.lang.diagnostics import near
from seoro.lang.frozen import Value

MARGIN: Final = "margin"
DURATION: Final = "duration"
MINIMIZE: Final = "column that is small near failures, such as robot.closest_approach (default: margin)"
MAXIMIZE: Final = "column that is large near failures, such as record.error"
"""Descriptions of options, for strategies with an objective."""


class Objective(Value):
    """Value of a point that a search lowers.

    Args:
        column: Column: `margin`, `duration`, a measurement `ROBOT.NAME`, or an item `record.NAME`.
        is_maximized: Whether large values are near failures; the objective is then the negative value.
    """

    column: str
    is_maximized: bool = False

    def value(self, told: Told) -> float | None:
        """Return the least value among the repeats of a point.

        Args:
            told: The runs of the point.

        Returns:
            The value; minus infinity if a run failed, and None if no run has a value.
        """
        if any(row.status is End.FAILED for row in told.rows):
            return -math.inf
        found = [number_in(row, self.column) for row in told.rows if row.status is End.PASSED]
        known = [value for value in found if value is not None]
        return min((-value if self.is_maximized else value for value in known), default=None)

    def is_known(self, told: Sequence[Told]) -> bool:
        """Return whether a run has a value; False if no run passed, so that this is unknown.

        Raises:
            UsageError: Runs passed, and none of them has a value.
        """
        passed = [_columns(row) for each in told for row in each.rows if row.status is End.PASSED]
        if not passed:
            return False
        known = sorted({name for columns in passed for name, value in columns.items() if value is not None})
        if self.column not in known:
            message = f"no run has a number in the column `{self.column}`"
            if self.column == MARGIN:
                message = "no run has a margin: the scenario has neither `compare` of numbers nor limits"
            hint = near(self.column, known) or f"`--minimize` or `--maximize` one of: {', '.join(known)}"
            raise UsageError(message, help=hint)
        return True


def objective_of(minimize: str, maximize: str) -> Objective:
    """Return the objective of the options `--minimize` and `--maximize`; by default, the least margin.

    Raises:
        UsageError: Both are given.
    """
    if minimize and maximize:
        raise UsageError("`--minimize` contradicts `--maximize`", help="leave out one of them")
    return Objective(maximize, is_maximized=True) if maximize else Objective(minimize or MARGIN)


def number_in(row: Row, column: str) -> float | None:
    """Return the number in a column of a row; None without one."""
    return _columns(row).get(column)


def _columns(row: Row) -> dict[str, float | None]:
    """Return the numbers of a row that can be minimized."""
    measured = {name: _number(value) for name, value in row.measured.items()}
    return {**measured, MARGIN: _number(row.margin), DURATION: _number(row.duration)}


def _number(value: Any) -> float | None:
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and not math.isnan(value)
    return float(value) if is_number else None
