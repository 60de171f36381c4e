"""Coverage of one campaign, and of several campaigns whose items are defined alike."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.coverage.unreachable import read_unreachable
from seoro.campaign.store.batches import read_batches
from seoro.campaign.store.covered import CoveredItem
from seoro.campaign.store.folder import read_campaign
from seoro.errors import UsageError


def coverage_of(folders: Sequence[Path]) -> MergedCoverage:
    """Merge the coverage of the runs of campaigns that passed or failed.

    Args:
        folders: Folders of the campaigns.

    Raises:
        UsageError: One is not the folder of a campaign, or the definitions of an item differ.
    """
    items: dict[str, tuple[CoveredItem, Path]] = {}
    for folder in folders:
        for item in read_campaign(folder).items:
            before, other = items.setdefault(item.item, (item, folder))
            if before.definition != item.definition:
                raise UsageError(
                    f"the item `{item.item}` is defined differently in {other} and {folder}: "
                    f"{_difference(before, item)}",
                    help="merge campaigns of the same scenario only, or repeat one of them",
                )
    unreachable = {(each.item, each.bucket): each for each in read_unreachable(folders[0])}
    for folder in folders[1:]:  # buckets that one campaign reaches or has not examined count
        found = {(each.item, each.bucket) for each in read_unreachable(folder)}
        unreachable = {key: each for key, each in unreachable.items() if key in found}
    merged = MergedCoverage((item for item, _ in items.values()), unreachable.values())
    for folder in folders:
        for batch in read_batches(folder):
            merged.add_batch(batch)
    return merged


def _difference(one: CoveredItem, other: CoveredItem) -> str:
    for name in ("unit", "target"):
        values = getattr(one, name), getattr(other, name)
        if values[0] != values[1]:
            return f"its {name} is {values[0]} and {values[1]}"
    if one.buckets != other.buckets:
        return "its buckets differ"
    return "its value, its event or its conditions differ"
