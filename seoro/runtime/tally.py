"""What was sampled of one coverage item: how often which bucket was met, and the grade (7.5.7)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seoro.lang.frozen import Value
from seoro.lang.plan import AnyCoverageItem, CoverageItem, CoverageKind, PhaseEvent


class ItemCoverage(Value):
    """What was sampled of an item.

    Args:
        item: Its name, after that of the type that declares it.
        kind: `cover` or `record`.
        event: At which it is sampled.
        unit: Of its values; empty if they have none.
        text: What it is about.
        target: How many samples a bucket needs.
        buckets: How often each was met; those that were not are not in it.
        total: How many there are; None if nothing bounds them.
        outside: How many values were in no bucket.
        ignored: How many values `ignore` left out.
        illegal: How many values `illegal` was true of; they are in no bucket.
    """

    item: str
    kind: CoverageKind
    event: str
    unit: str
    text: str
    target: int
    buckets: tuple[tuple[str, int], ...]
    total: int | None
    outside: int
    ignored: int
    illegal: int

    @property
    def reached(self) -> int:
        """How many buckets have as many samples as they need."""
        if self.target == 0:
            return self.total or 0
        return sum(count >= self.target for _, count in self.buckets)

    @property
    def grade(self) -> float | None:
        """The share of buckets that were reached, from 0 to 1; None for records, and without bounds."""
        if self.kind is CoverageKind.RECORD or not self.total:
            return None
        return self.reached / self.total

    def plain(self) -> dict[str, object]:
        """It as JSON knows it."""
        return {
            "item": self.item,
            "kind": self.kind.value,
            "event": self.event,
            "unit": self.unit,
            "text": self.text,
            "target": None if self.kind is CoverageKind.RECORD else self.target,
            "buckets": dict(self.buckets),
            "total": self.total,
            "grade": self.grade,
            "outside": self.outside,
            "ignored": self.ignored,
            "illegal": self.illegal,
        }


@dataclass(eq=False)
class Tally:
    """Counts the samples of an item, of all instances of its type.

    Args:
        item: The item.
        total: How many buckets there are.
    """

    item: AnyCoverageItem
    total: int | None
    counts: dict[str, int] = field(default_factory=dict)
    outside: int = 0
    ignored: int = 0
    illegal: int = 0

    def count(self, bucket: str | None) -> None:
        """Count a sample; None is outside of all buckets."""
        if bucket is None:
            self.outside += 1
        else:
            self.counts[bucket] = self.counts.get(bucket, 0) + 1

    def result(self) -> ItemCoverage:
        """What was sampled so far."""
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
