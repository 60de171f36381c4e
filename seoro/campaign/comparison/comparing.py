"""Comparison of two campaigns: is the second one worse than the first?"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Final

from seoro.campaign.comparison.measurements import MeasurementChange, measurement_changes
from seoro.campaign.comparison.pairs import Joined, Pair, Pairs, join
from seoro.campaign.comparison.settings import Difference, differences
from seoro.campaign.runs import End
from seoro.campaign.statistics.comparison import mcnemar
from seoro.campaign.statistics.drops import Passed, fisher, paired_drop_bound, unpaired_drop_bound
from seoro.campaign.stopping.rules import percent
from seoro.campaign.store.folder import CampaignFile, read_campaign
from seoro.embed.arguments import AnyPath, number_with, to_path
from seoro.lang.frozen import Value

MARGIN: Final = 0.02
ERROR: Final = 0.05  # of the test for a drop
_VERDICTS: Final = (End.PASSED, End.FAILED)
PAIRED: Final = 0.5  # of the runs of the smaller campaign, from which on pairs are compared


class Outcome(Enum):
    """Outcome of a comparison."""

    WORSE = "worse"
    NOT_WORSE = "not worse"
    UNDECIDED = "undecided"


class Comparison(Value):
    """Comparison of two campaigns.

    Args:
        before: Folder of the first campaign.
        after: Folder of the second one.
        outcome: Outcome for the second one.
        reason: Reason of the outcome, for people.
        margin: Largest drop of the pass rate that counts as not worse.
        is_paired: Whether runs with the same values, seed and repeat were compared.
        counts: Runs of both that passed and that have a verdict; of pairs, if they were compared.
        p: P-value of equal pass rates: McNemar's exact test of pairs, Fisher's exact test otherwise; None without
            runs.
        drop_bound: Upper bound for the drop of the pass rate, with 95 % confidence; None without runs.
        failing: Pairs that passed before and fail now.
        passing: Pairs that failed before and pass now.
        lost: Pairs with a verdict before and none now.
        equal: Number of pairs with equal traces.
        joined: All pairs, and the ends of all runs.
        measurements: Changes of measurements.
        differences: Settings that differ.
        campaigns: Content of both `campaign.json`.
    """

    before: Path
    after: Path
    outcome: Outcome
    reason: str
    margin: float
    is_paired: bool
    counts: tuple[Passed, Passed]
    p: float | None
    drop_bound: float | None
    failing: Pairs
    passing: Pairs
    lost: Pairs
    equal: int
    joined: Joined
    measurements: tuple[MeasurementChange, ...]
    differences: tuple[Difference, ...]
    campaigns: tuple[CampaignFile, CampaignFile]

    @property
    def is_fixed(self) -> bool:
        """Whether no result determined the numbers of runs; otherwise errors are more frequent than stated."""
        return all(each.has_fixed_runs for each in self.campaigns)

    def command(self, pair: Pair) -> str:
        """Return the command that repeats the run of the second campaign."""
        return replay_command(self.after, pair.after.run)

    def __repr__(self) -> str:
        return f"<Comparison: {self.outcome.value}, {self.reason}>"

    def _repr_html_(self) -> str:
        """Return the outcome and changed measurements for notebooks."""
        from seoro.campaign.comparison.page import summary_html  # noqa: PLC0415 - it needs this module

        return summary_html(self)


def replay_command(folder: Path, run: int) -> str:
    """Return the command that repeats a run of a campaign."""
    return shlex.join(["seoro", "campaign", "replay", str(folder), str(run)])


_to_margin = number_with(lambda margin: 0.0 < margin < 1.0, "more than 0 and less than 1")


def compare(before: AnyPath, after: AnyPath, *, margin: float = MARGIN) -> Comparison:
    """Compare two campaigns, such as of two versions of a robot.

    Runs with the same values, seed and repeat are compared in pairs, if these are at least half of the smaller
    campaign. Otherwise all runs are compared as independent ones.

    Args:
        before: Folder of the first campaign.
        after: Folder of the second one.
        margin: Largest drop of the pass rate that counts as not worse, between 0 and 1.

    Raises:
        UsageError: A folder is not that of a campaign, a row is invalid, or the margin is invalid.
    """
    first, second = to_path("before", before), to_path("after", after)
    tolerated = _to_margin("margin", margin)
    campaigns = read_campaign(first), read_campaign(second)
    joined = join(first, second)
    both = joined.select(lambda first, second: first in _VERDICTS and second is End.PASSED)
    failing = joined.select(lambda first, second: first is End.PASSED and second is End.FAILED)
    passing = joined.select(lambda first, second: first is End.FAILED and second is End.PASSED)
    never = joined.select(lambda first, second: first is End.FAILED and second is End.FAILED)
    decided = len(both) + len(failing) + len(never)
    all_counts = _counts(joined.before), _counts(joined.after)
    is_paired = bool(decided) and decided >= PAIRED * min(all_counts[0][1], all_counts[1][1])
    p: float | None = None
    bound: float | None = None
    if is_paired:
        counts = (decided - len(never) - len(passing), decided), (len(both), decided)
        p = mcnemar(len(failing), len(passing))
        bound = paired_drop_bound(len(failing), len(passing), decided)
    else:
        counts = all_counts
        if counts[0][1] and counts[1][1]:
            p, bound = fisher(*counts), unpaired_drop_bound(*counts)
    lost = joined.select(lambda first, second: first in _VERDICTS and second not in _VERDICTS)
    is_sample = all(each.is_sample for each in campaigns)
    outcome, reason = _decide(counts, p, bound, tolerated, len(lost), can_judge=is_paired or is_sample)
    return Comparison(
        first,
        second,
        outcome,
        reason,
        tolerated,
        is_paired,
        counts,
        p,
        bound,
        failing,
        passing,
        lost,
        joined.equal,
        joined,
        measurement_changes(joined),
        differences(*campaigns),
        campaigns,
    )


def _decide(
    counts: tuple[Passed, Passed],
    p: float | None,
    bound: float | None,
    margin: float,
    lost: int,
    *,
    can_judge: bool,
) -> tuple[Outcome, str]:
    if p is None or bound is None:
        return Outcome.UNDECIDED, "a campaign has no run with a verdict"
    if not can_judge:
        return Outcome.UNDECIDED, "the campaigns share too few runs, and are not independent random samples"
    (passed, runs), (others, total) = counts
    if p <= ERROR and others / total < passed / runs:
        return Outcome.WORSE, "the pass rate has dropped"
    if lost:
        return Outcome.UNDECIDED, f"{lost:,} of the runs that had a verdict ended without one"
    if bound < margin:
        return Outcome.NOT_WORSE, f"the pass rate has not dropped by {percent(margin)} or more"
    return Outcome.UNDECIDED, f"the pass rate may have dropped by up to {percent(bound)}; more runs narrow this"


def _counts(ends: Mapping[End, int]) -> Passed:
    passed = ends.get(End.PASSED, 0)
    return passed, passed + ends.get(End.FAILED, 0)
