"""Watch over a campaign: the verdicts of its runs in order, and whether a rule ends it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Final

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.runs import End, Row
from seoro.campaign.stopping.rules import CoverageGoal, RateBound, RateTest, Rule, Stop
from seoro.campaign.store.batches import Batch

_IS_PASSED: Final = {End.PASSED: True, End.FAILED: False}


class Watch:
    """Counts verdicts in the order of the runs, and applies the stopping rules after each.

    Runs that fail early would otherwise come first, and distort the rate. In the order of their numbers, a rule
    decides at the same run with any number of workers, and after an interruption.

    Args:
        rules: Stopping rules, the first of which ends the campaign.
        budget: Wall time [s] from now; None without a limit.
        clock: Clock of the budget [s].
        coverage: Coverage without runs, for campaigns with `cover` items.

    Attributes:
        passed, failed: Number of runs with these verdicts, up to the first that has not ended.
        coverage: Coverage; with a rule about it, of these runs only.
        needs_coverage: Whether a rule is about the coverage.
        stop: End by a rule or by the budget; None to continue.
    """

    def __init__(
        self,
        rules: Sequence[Rule] = (),
        budget: float | None = None,
        clock: Callable[[], float] = time.monotonic,
        coverage: MergedCoverage | None = None,
    ) -> None:
        self.passed = self.failed = 0
        self._rules = rules
        self._budget = budget
        self._clock = clock
        self._begun = clock()
        self._next = 1
        self._early: dict[int, tuple[End, Row | None]] = {}  # runs that have ended before an earlier one
        self.needs_coverage = any(isinstance(rule, CoverageGoal) for rule in rules)
        self.coverage = coverage or MergedCoverage()
        self.stop: Stop | None = None

    def record(self, row: Row) -> None:
        """Take the end of a run; repeated rows of a run count once."""
        if row.run >= self._next and row.run not in self._early:
            kept = row if row.coverage and row.status in _IS_PASSED else None
            if kept is not None and not self.needs_coverage:  # its order has no effect, and it needs memory
                self.coverage.add(kept)
                kept = None
            self._early[row.run] = row.status, kept
        self._count_next()

    def record_batch(self, batch: Batch) -> None:
        """Take the ends of runs of earlier sessions, each for the first time.

        Raises:
            UsageError: A row is invalid.
        """
        if self.needs_coverage:
            for position in range(len(batch)):
                self.record(batch.row(position))
            return
        self.coverage.add_batch(batch)
        runs = batch.column("run")
        for end, positions in batch.ends.items():
            self._early.update((runs[position], (end, None)) for position in positions)
        self._count_next()

    def _count_next(self) -> None:
        """Count the runs before the first that has not ended."""
        while (ended := self._early.pop(self._next, None)) is not None:
            end, kept = ended
            self._next += 1
            if kept is not None:
                self.coverage.add(kept)
            if end in _IS_PASSED:
                self._count(_IS_PASSED[end])

    def _count(self, is_passed: bool) -> None:
        self.passed += is_passed
        self.failed += not is_passed
        if self.stop is not None:
            return
        for rule in self._rules:
            coverage = self.coverage.share if isinstance(rule, CoverageGoal) else 0.0
            stop = rule.check(self.passed, self.failed, coverage)
            if stop is not None:
                runs = self.passed + self.failed
                self.stop = Stop(f"{stop.reason}, after {runs:,} runs", stop.decision)
                return

    @property
    def has_test(self) -> bool:
        """Whether a rule decides about the rate."""
        return any(isinstance(rule, RateTest | RateBound) for rule in self._rules)

    def is_enough(self) -> bool:
        """Return whether no more runs shall begin, by a rule or by the budget."""
        if self.stop is None and self._budget is not None and self._clock() - self._begun >= self._budget:
            self.stop = Stop("the budget is used up")
        return self.stop is not None
