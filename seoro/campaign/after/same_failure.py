"""Failures that count as the same, and the values of a failed run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from seoro.campaign.after.finding import FoundRun
from seoro.campaign.runs import End, Row
from seoro.campaign.space.axes import Axis, Interval
from seoro.campaign.space.space import Space
from seoro.campaign.store.folder import TRACE
from seoro.campaign.strategies.contract import Told
from seoro.campaign.work.measurements import value_at
from seoro.files.inputs import Kind, open_input
from seoro.lang.frozen import Value

FAILS: Final = "fails"
PASSES: Final = "passes"
OTHER: Final = "other failure"
EXCLUDED: Final = "excluded"


class SameFailure(Value):
    """Predicate: runs that fail for the same reason at the same place.

    Args:
        reason_key: Reason without numbers.
        where: Place in the text.
        any_failure: Whether all failures are the same.
    """

    reason_key: str
    where: str
    any_failure: bool = False

    def matches(self, row: Row) -> bool:
        """Return whether a run failed in this way."""
        is_alike = (row.reason_key, row.where) == (self.reason_key, self.where)
        return row.status is End.FAILED and (self.any_failure or is_alike)

    def holds(self, told: Told) -> bool:
        """Return whether most repeats of a point failed in this way; False if constraints exclude it."""
        return 2 * sum(map(self.matches, told.rows)) > len(told.rows)

    def ending_of(self, row: Row) -> str:
        """Describe how a run ended: `fails` in this way, `passes`, `other failure`, `excluded`, or its status."""
        if row.status is End.FAILED:
            return FAILS if self.matches(row) else OTHER
        named = {End.PASSED: PASSES, End.IMPOSSIBLE: EXCLUDED}
        return named.get(row.status, str(row.status.value))

    def ending(self, told: Told) -> str:
        """Describe how most repeats of a point ended."""
        if self.holds(told):
            return FAILS
        endings = Counter(self.ending_of(row) for row in told.rows if not self.matches(row))
        return endings.most_common(1)[0][0] if endings else EXCLUDED


def values_of_run(found: FoundRun, space: Space) -> dict[str, str]:
    """Return the values of the axes in a run, in the notation of the scenario.

    Values that the run itself has drawn come from its trace; without the trace, they are left out.

    Args:
        found: The run.
        space: Axes of the campaign.
    """
    drawn: Mapping[str, Any] = {}
    if any(axis.path not in found.planned.values for axis in space.axes):
        drawn = _drawn(found)
    values: dict[str, str] = {}
    for axis in space.axes:
        text = found.planned.values.get(axis.path) or _drawn_text(axis, drawn)
        if text is not None:
            values[axis.path] = text
    return values


def _drawn(found: FoundRun) -> Mapping[str, Any]:
    """Return the parameters at the start of the trace, if it was kept."""
    trace: Path = found.folder / found.row.folder / TRACE
    if not found.row.folder or not trace.is_file():
        return {}
    with open_input(trace, Kind.TRACE) as file:
        parameters: Mapping[str, Any] = json.loads(file.readline()).get("parameters", {})
    return parameters


def _drawn_text(axis: Axis, drawn: Mapping[str, Any]) -> str | None:
    """Return a value of a trace as the axis writes it; None if either does not have it."""
    try:
        value = value_at(drawn, axis.path)
    except KeyError:
        return None
    if isinstance(axis, Interval):
        return axis.text(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
    if axis.numbers is not None:
        return axis.texts[axis.numbers.index(value)] if value in axis.numbers else None
    text = json.dumps(value, ensure_ascii=False)
    return text if text in axis.texts else None
