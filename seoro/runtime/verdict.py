"""Results of behaviors and runs: outcomes, verdicts and sampled coverage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from enum import Enum
from typing import Any

from seoro.lang.frozen import Value
from seoro.lang.plan import CoverageKind
from seoro.lang.source import Span
from seoro.runtime.explanation import Explanation


class Status(Enum):
    """End states of a behavior."""

    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"


class Outcome(Value):
    """End of a behavior.

    Args:
        status: End state.
        reason: Reason of the failure or cancellation.
        span: Text that decided it.
        explanation: Activities at the time of the failure.
        has_begun: Whether the behavior has started at all.
    """

    status: Status
    reason: str = ""
    span: Span | None = None
    explanation: Explanation | None = None
    has_begun: bool = True

    @property
    def failed(self) -> bool:
        """Whether the behavior failed. A cancellation is not a failure."""
        return self.status is Status.FAILED


SUCCEEDED = Outcome(Status.SUCCEEDED)
CANCELLED = Outcome(Status.CANCELLED)


def failure(reason: str, span: Span, explanation: Explanation | None = None) -> Outcome:
    """Return the outcome of a failed behavior."""
    return Outcome(Status.FAILED, reason, span, explanation)


class RunStatus(Enum):
    """End states of a run. `error` does not judge the system under test."""

    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"
    CANCELLED = "cancelled"


class ItemCoverage(Value):
    """Samples of a coverage item (7.5.7).

    Args:
        item: Name of the item, qualified by the declaring type.
        kind: `cover` or `record`.
        event: Event at which it is sampled.
        unit: Unit of its values; empty without one.
        text: Description.
        target: Number of samples that a bucket needs.
        buckets: Number of samples by bucket, without empty buckets.
        total: Number of buckets; None if unbounded.
        outside: Number of values outside all buckets.
        ignored: Number of values excluded by `ignore`.
        illegal: Number of values for which `illegal` was true; they are in no bucket.
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
        """Number of buckets that reached the target."""
        if self.target == 0:
            return self.total or 0
        return sum(count >= self.target for _, count in self.buckets)

    @property
    def grade(self) -> float | None:
        """Share of buckets that reached the target, from 0 to 1; None for records and unbounded items."""
        if self.kind is CoverageKind.RECORD or not self.total:
            return None
        return self.reached / self.total

    def plain(self) -> dict[str, object]:
        """Return the fields for JSON."""
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


class Cancelled(Value):
    """A cancelled behavior, or a background resource of an action that the end of the run closed.

    Args:
        path: Path of the behavior.
        type: Its kind, as in the trace.
        span: Its text.
        clean_up: Duration of its clean-up [s], on the machine's clock.
        overran: Whether the clean-up exceeded its limit.
    """

    path: str
    type: str
    span: Span
    clean_up: float
    overran: bool

    def plain(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return {
            "path": self.path,
            "type": self.type,
            "source": str(self.span),
            "clean_up": round(self.clean_up, 3),
            "overran": self.overran,
        }


class Verdict(Value):
    """Result of a run.

    Args:
        status: End state.
        reason: Reason as a sentence; empty for a passed run.
        span: Text of the scenario that decided, or None.
        duration: Duration of the run [s], on the run's clock.
        wall_duration: Duration of the run [s], on the machine's clock.
        seed: Seed of the run.
        scenario: Name of the scenario.
        file: Its file, as given by the user.
        cancelled: Behaviors cancelled by the end of the run, in order of their clean-up.
        coverage: Results of `cover` and `record`, in order of their first use.
        logs: Last logs, formatted.
        unobserved: Moved robots whose contacts are not reported.
        explanation: Waits and running behaviors at the decision; None for a passed run.
        margin: Least distance of a checked value to its limit, as a share of the limit; negative beyond it. None
            without such a check.
        requirements: Names of requirements that the scenario covers.
    """

    status: RunStatus
    reason: str
    span: Span | None
    duration: float
    wall_duration: float
    seed: int
    scenario: str
    file: str
    cancelled: tuple[Cancelled, ...] = ()
    coverage: tuple[ItemCoverage, ...] = ()
    logs: tuple[str, ...] = ()
    unobserved: tuple[str, ...] = ()
    explanation: Explanation | None = None
    margin: float | None = None
    requirements: tuple[str, ...] = ()

    def __repr__(self) -> str:
        reason = f" {self.reason!r}" if self.reason else ""
        return f"<Verdict of {self.scenario}: {self.status.value}{reason}>"

    def _repr_html_(self) -> str:
        """Return the verdict for notebooks."""
        return self.card({})

    def card(self, facts: Mapping[str, object]) -> str:
        """Return the verdict as a card for notebooks, with more facts."""
        from seoro.text.notebook import card  # noqa: PLC0415 - for notebooks only

        own = {
            "reason": self.reason,
            "decided by": "" if self.span is None else str(self.span),
            "duration": f"{self.duration:.3f} s ({self.wall_duration:.3f} s real)",
            "seed": self.seed,
            "smallest margin": self.margin,
        }
        activities = () if self.explanation is None else self.explanation.activities
        lines = [
            f"{each.kind.value} since {each.ongoing.since:.3f} s: {each.ongoing.text} ({each.ongoing.span})"
            for each in activities
        ]
        return card(self.scenario, self.status.value, own | dict(facts), lines)

    @property
    def passed(self) -> bool:
        """Whether the scenario passed."""
        return self.status is RunStatus.PASSED


def with_write_error(verdict: Verdict, why: str) -> Verdict:
    """Turn the verdict of a run into an error because a requested result could not be written."""
    if verdict.status is RunStatus.ERROR:
        return verdict
    found = f"{verdict.status.value}, {verdict.reason}" if verdict.reason else verdict.status.value
    return replace(verdict, status=RunStatus.ERROR, reason=f"{why}; the run itself: {found}")
