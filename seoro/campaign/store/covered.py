"""Definitions of `cover` items, as in `campaign.json`, and buckets that constraints exclude."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class CoveredItem(BaseModel):
    """Definition of a `cover` item.

    Attributes:
        item: Its name, qualified by the declaring type.
        definition: Hash of all that determines its buckets and samples.
        unit: Unit of its buckets; empty without one.
        target: Samples that each bucket needs.
        buckets: Names of its buckets; None if they are unbounded or too many.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    item: str
    definition: str
    unit: str = ""
    target: int = 1
    buckets: tuple[str, ...] | None = None


class Unreachable(BaseModel):
    """Bucket that constraints exclude, a line of `unreachable.jsonl`.

    Attributes:
        item: Qualified name of the item.
        bucket: Name of the bucket.
        reasons: The constraints, with their places.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    item: str
    bucket: str
    reasons: tuple[str, ...]
