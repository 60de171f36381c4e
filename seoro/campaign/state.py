"""State of a campaign: its counts, its pass rate, and whether a rule ends it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import Row
from seoro.campaign.stopping.grammar import parse_rule
from seoro.campaign.stopping.rate import Rate, Validity
from seoro.campaign.stopping.watch import Watch
from seoro.campaign.store.batches import Batch
from seoro.campaign.store.covered import Unreachable
from seoro.campaign.store.folder import CampaignFile


class State:
    """State of a campaign; its budget begins now.

    Args:
        campaign: Content of its `campaign.json`.
        batches: Rows of runs that have ended before.
        unreachable: Buckets of `cover` items that constraints exclude.

    Attributes:
        campaign: As given.
        tally: Counts of runs.
        watch: Verdicts in the order of the runs.

    Raises:
        UsageError: A stopping rule or a row is invalid.
    """

    def __init__(
        self, campaign: CampaignFile, batches: Iterable[Batch], unreachable: Iterable[Unreachable] = ()
    ) -> None:
        self.campaign = campaign
        self.tally = Tally()
        rules = [parse_rule(text) for text in campaign.until]
        self.watch = Watch(rules, campaign.budget, coverage=MergedCoverage(campaign.items, unreachable))
        for batch in batches:
            self.record_batch(batch)

    def record(self, row: Row) -> None:
        """Take the end of a run."""
        self.tally.count(row)
        self.watch.record(row)

    def record_batch(self, batch: Batch) -> None:
        """Take the ends of runs of an earlier session.

        Raises:
            UsageError: A row is invalid.
        """
        self.tally.count_batch(batch)
        self.watch.record_batch(batch)

    @property
    def is_complete(self) -> bool:
        """Whether all runs have ended, if their number is known in advance."""
        return self.tally.runs == self.campaign.runs

    def rate(self, *, is_complete: bool) -> Rate:
        """Return the pass rate of the runs before the first that has not ended.

        Args:
            is_complete: Whether the campaign was carried out to its end.
        """
        return rate_of(self.campaign, self.watch, is_complete=is_complete)


def progress_data(state: State) -> dict[str, Any]:
    """Return how far a campaign is, as JSON data."""
    campaign, stop = state.campaign, state.watch.stop
    return {
        "scenario": campaign.manifest.shown,
        "requirements": list(campaign.requirements),
        "runs": state.tally.runs,
        "planned": campaign.runs,
        "ends": {end.value: count for end, count in state.tally.ends.items()},
        "is_complete": state.is_complete,
        "stopped": None if stop is None else stop.reason,
    }


def rate_of(campaign: CampaignFile, watch: Watch, *, is_complete: bool) -> Rate:
    """Return the pass rate of the runs before the first that has not ended.

    Args:
        campaign: Content of its `campaign.json`.
        watch: Verdicts of its runs.
        is_complete: Whether the campaign was carried out to its end.
    """
    validity = Validity.NONE
    if campaign.is_sample:
        validity = Validity.FIXED if is_complete and campaign.has_fixed_runs else Validity.ALWAYS
    return Rate(watch.passed, watch.failed, validity)
