"""Flaky runs: equal ids promise equal runs, so another verdict or trace shows a defect of determinism."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable

from seoro.campaign.runs import End, Row
from seoro.lang.frozen import Value


class Flaky(Value):
    """Runs with one id that differ.

    Args:
        id: Their identity.
        rows: The runs, in the given order.
        has_other_verdict: Whether their verdicts differ, not only their traces.
    """

    id: str
    rows: tuple[Row, ...]
    has_other_verdict: bool


class RepeatedIds:
    """Ids that occur several times.

    Attributes:
        found: The ids.
    """

    def __init__(self) -> None:
        self.found: set[str] = set()
        self._seen: set[str] = set()

    def add(self, ids: Collection[str]) -> None:
        """Add ids."""
        new = set(ids)
        if len(new) < len(ids):
            self.found.update(each for each, count in Counter(ids).items() if count > 1)
        self.found |= new & self._seen
        self._seen |= new


def find_flaky(rows: Iterable[Row]) -> tuple[Flaky, ...]:
    """Find runs with equal ids and other verdicts or traces.

    Runs without a verdict, such as of a crashed worker, are left out.

    Args:
        rows: Rows of one or several campaigns.
    """
    by_id: dict[str, list[Row]] = {}
    for row in rows:
        if row.status in (End.PASSED, End.FAILED):
            by_id.setdefault(row.id, []).append(row)
    found = []
    for each, group in by_id.items():
        has_other_verdict = len({row.status for row in group}) > 1
        if has_other_verdict or len({row.trace_sha for row in group if row.trace_sha}) > 1:
            found.append(Flaky(each, tuple(group), has_other_verdict))
    return tuple(found)
