"""`Tally`: counts the samples of one coverage item (7.5.7)."""

from __future__ import annotations

from dataclasses import field

from seoro.lang.lazy_dataclass import lazy_dataclass
from seoro.lang.plan import AnyCoverageItem, CoverageItem, PhaseEvent
from seoro.runtime.verdict import ItemCoverage


@lazy_dataclass
class Tally:
    """Counts samples of an item, over all instances of its type.

    Args:
        item: The item.
        total: Number of buckets.
    """

    item: AnyCoverageItem
    total: int | None
    counts: dict[str, int] = field(default_factory=dict)
    outside: int = 0
    ignored: int = 0
    illegal: int = 0

    def count(self, bucket: str | None) -> None:
        """Count a sample; None for a value outside all buckets."""
        if bucket is None:
            self.outside += 1
        else:
            self.counts[bucket] = self.counts.get(bucket, 0) + 1

    def result(self) -> ItemCoverage:
        """Return the current result."""
        item = self.item
        unit = item.unit if isinstance(item, CoverageItem) else None
        return ItemCoverage(
            item=f"{item.owner}.{item.name}",
            kind=item.kind,
            event=item.event.phase.value if isinstance(item.event, PhaseEvent) else item.event.name,
            unit=unit.name if unit is not None else "",
            text=item.text,
            target=item.target,
            buckets=tuple(self.counts.items()),
            total=self.total,
            outside=self.outside,
            ignored=self.ignored,
            illegal=self.illegal,
        )
