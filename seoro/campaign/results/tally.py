"""Counts of a campaign so far, in constant memory."""

from __future__ import annotations

from collections import Counter
from dataclasses import field

from seoro.campaign.runs import End, Row
from seoro.campaign.store.batches import Batch
from seoro.deferred import dataclass


@dataclass(eq=False)
class Tally:
    """Counts the runs of a campaign by how they ended.

    Args:
        ends: Number of runs by end.
        impossible: Number of planned runs that constraints exclude.
    """

    ends: Counter[End] = field(default_factory=Counter)
    impossible: int = 0

    def count(self, row: Row) -> None:
        """Count a row."""
        if row.status is End.IMPOSSIBLE:
            self.impossible += 1
        else:
            self.ends[row.status] += 1

    def count_batch(self, batch: Batch) -> None:
        """Count the rows of a batch."""
        counts = {end: len(positions) for end, positions in batch.ends.items()}
        self.impossible += counts.pop(End.IMPOSSIBLE, 0)
        self.ends.update(counts)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.ends.total()

    @property
    def text(self) -> str:
        """The counts, for people: `12 passed, 3 failed`."""
        shown = [f"{self.ends[end]:,} {end.value}" for end in End if self.ends[end]]
        excluded = [f"{self.impossible:,} excluded by constraints"] if self.impossible else []
        return ", ".join([*shown, *excluded]) or "no runs"
