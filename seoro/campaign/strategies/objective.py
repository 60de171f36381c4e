"""Objectives of a search: a column of `runs.csv` that is small near failures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

from seoro.campaign.runs import End, Row
from seoro.campaign.strategies.contract import Told
from seoro.errors import UsageError
from seoro.lang.diagnostics import near

MARGIN: Final = "margin"
DURATION: Final = "duration"


def objective(column: str, told: Told) -> float | None:
    """Return the least value of a column among the repeats of a point.

    Args:
        column: Its name.
        told: The runs of the point.

    Returns:
        The value; minus infinity if a run failed, and None if no run has a value.
    """
    if any(row.status is End.FAILED for row in told.rows):
        return -math.inf
    found = [_columns(row).get(column) for row in told.rows if row.status is End.PASSED]
    return min((value for value in found if value is not None), default=None)


def has_objective(column: str, told: Sequence[Told]) -> bool:
    """Return whether a run has a value; False if no run passed, so that this is unknown.

    Raises:
        UsageError: Runs passed, and none of them has a value.
    """
    passed = [_columns(row) for each in told for row in each.rows if row.status is End.PASSED]
    if not passed:
        return False
    known = sorted({name for columns in passed for name, value in columns.items() if value is not None})
    if column not in known:
        message = f"no run has a number in the column `{column}`"
        raise UsageError(message, help=near(column, known) or f"`--minimize` one of: {', '.join(known)}")
    return True


def _columns(row: Row) -> dict[str, float | None]:
    """Return the numbers of a row that can be minimized."""
    measured = {name: _number(value) for name, value in row.measured.items()}
    return {**measured, MARGIN: _number(row.margin), DURATION: _number(row.duration)}


def _number(value: Any) -> float | None:
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and not math.isnan(value)
    return float(value) if is_number else None
