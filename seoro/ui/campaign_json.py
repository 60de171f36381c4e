"""Results of a campaign as JSON data for its page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any, Final

from seoro.campaign.coverage.counts import ItemCounts, MergedCoverage
from seoro.campaign.report.columns import Column
from seoro.campaign.report.grouping import Bucket, influence
from seoro.campaign.report.summary import MORE, FailureGroup, Summary
from seoro.campaign.runs import End, Row
from seoro.campaign.statistics.rates import fixed_bounds
from seoro.campaign.stopping.rate import Rate
from seoro.campaign.store.folder import CampaignFile
from seoro.ui.campaign_reader import CampaignReader

MOST_BUCKETS: Final = 20  # of an axis
MOST_AXES: Final = 50
MOST_MEASUREMENTS: Final = 20
MOST_GROUPS: Final = 20
MOST_HOLES: Final = 20  # of a `cover` item

KeptId = Callable[[Row], str | None]
"""Returns the id of a kept run for its page; None if it was not kept."""


def snapshot_of(reader: CampaignReader, kept_id: KeptId) -> Mapping[str, Any]:
    """Return the results so far.

    Args:
        reader: The campaign, as far as it was read.
        kept_id: Ids of kept runs.
    """
    campaign, summary = reader.campaign, reader.summary
    return {
        **described(campaign),
        "done": summary.runs,
        "counts": {end.value: summary.ends[end] for end in End if end is not End.IMPOSSIBLE},
        "impossible": summary.impossible,
        "rate": _rate(reader.rate),
        "stop": reader.stop,
        "axes": list(_axes(summary.parameters, MOST_AXES)),
        "measurements": list(_axes(summary.measurements, MOST_MEASUREMENTS)),
        "groups": _groups(summary),
        "latest": [_failure(row, kept_id) for row in reader.latest],
        "coverage": _coverage(summary.coverage),
        "hosts": dict(summary.hosts),
        "cpu": summary.cpu,
        "firstStart": _seconds(summary.first),
        "lastStart": _seconds(summary.last),
    }


def described(campaign: CampaignFile) -> Mapping[str, Any]:
    """Return the plan of a campaign."""
    return {
        "title": campaign.manifest.shown,
        "runs": campaign.runs,
        "repeat": campaign.repeat,
        "seed": campaign.seed,
        "strategy": campaign.strategy.name,
        "simulator": campaign.simulator,
        "version": campaign.version,
        "until": list(campaign.until),
        "budget": campaign.budget,
        "keep": campaign.keep,
    }


def _seconds(time: str) -> float | None:
    """Return a time of a row [s since 1970]; None without one."""
    try:
        return datetime.fromisoformat(time).timestamp()
    except ValueError:
        return None


def _rate(rate: Rate) -> Mapping[str, Any]:
    bounds = rate.bounds
    return {
        "passed": rate.passed,
        "failed": rate.failed,
        "share": rate.share,
        "low": None if bounds is None else bounds.low,
        "high": None if bounds is None else bounds.high,
        "validity": rate.validity.value,
    }


def _axes(columns: Mapping[str, Column], most: int) -> Iterator[Mapping[str, Any]]:
    for path, column in list(columns.items())[:most]:
        buckets = column.grouping(MOST_BUCKETS).buckets
        yield {"path": path, "influence": influence(buckets), "buckets": [_bucket(each) for each in buckets]}


def _bucket(bucket: Bucket) -> Mapping[str, Any]:
    bounds = fixed_bounds(bucket.passed, bucket.runs) if bucket.runs else None
    return {
        "label": bucket.label,
        "passed": bucket.passed,
        "failed": bucket.failed,
        "from": bucket.low,
        "to": bucket.high,
        "rateLow": None if bounds is None else bounds.low,
        "rateHigh": None if bounds is None else bounds.high,
    }


def _groups(summary: Summary) -> Sequence[Mapping[str, Any]]:
    found = sorted(summary.failures.items(), key=lambda item: -item[1].count)
    return [_group(key, group) for key, group in found[:MOST_GROUPS]]


def _group(key: tuple[str, str], group: FailureGroup) -> Mapping[str, Any]:
    row = group.example
    return {
        "reason": MORE[0] if key == MORE else row.reason or row.status.value,
        "where": key[1],
        "count": group.count,
        "example": row.run,
    }


def _failure(row: Row, kept_id: KeptId) -> Mapping[str, Any]:
    return {
        "run": row.run,
        "status": row.status.value,
        "reason": row.reason,
        "where": row.where,
        "values": dict(row.values),
        "seed": row.seed,
        "started": row.started,
        "kept": kept_id(row),
    }


def _coverage(coverage: MergedCoverage) -> Sequence[Mapping[str, Any]]:
    return [_item(each) for each in coverage.items.values()]


def _item(item: ItemCounts) -> Mapping[str, Any]:
    holes = item.holes
    return {
        "item": item.item,
        "unit": item.unit,
        "reached": item.reached,
        "reachable": len(item.buckets) if item.reachable is None else item.reachable,
        "holes": holes[:MOST_HOLES],
        "holeCount": len(holes),
        "illegal": item.illegal,
    }
