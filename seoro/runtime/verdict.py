"""How behaviors and runs end."""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from typing import Any

from seoro.lang.frozen import Value
from seoro.lang.source import Span
from seoro.runtime.explanation import Explanation
from seoro.runtime.tally import ItemCoverage


class Status(Enum):
    """How a behavior ended."""

    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"


class Outcome(Value):
    """The end of a behavior.

    Args:
        status: How it ended.
        reason: Why it failed or was cancelled.
        span: Which text decided that.
        explanation: What went on when it failed.
        has_begun: Whether it was carried out at all.
    """

    status: Status
    reason: str = ""
    span: Span | None = None
    explanation: Explanation | None = None
    has_begun: bool = True

    @property
    def failed(self) -> bool:
        """Whether the behavior failed; being cancelled is no failure."""
        return self.status is Status.FAILED


SUCCEEDED = Outcome(Status.SUCCEEDED)
CANCELLED = Outcome(Status.CANCELLED)


def failure(reason: str, span: Span, explanation: Explanation | None = None) -> Outcome:
    """The outcome of a behavior that failed here."""
    return Outcome(Status.FAILED, reason, span, explanation)


class RunStatus(Enum):
    """How a run ended; `error` is no verdict on the system under test."""

    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"
    CANCELLED = "cancelled"


class Cancelled(Value):
    """A behavior that was cancelled; also what an action left open until the run ended.

    Args:
        path: Of the behavior.
        type: Its kind, as the trace calls it.
        span: Its text.
        clean_up: How long it took until it had ended [s], on the machine's clock.
        overran: Whether that was longer than it may take.
    """

    path: str
    type: str
    span: Span
    clean_up: float
    overran: bool

    def plain(self) -> dict[str, Any]:
        """As JSON knows it."""
        return {
            "path": self.path,
            "type": self.type,
            "source": str(self.span),
            "clean_up": round(self.clean_up, 3),
            "overran": self.overran,
        }


class Verdict(Value):
    """The result of a run.

    Args:
        status: How it ended.
        reason: Why, in a sentence; empty for a run that passed.
        span: Which text of the scenario decided, if any did.
        duration: Length of the run [s], on the run's clock.
        wall_duration: Length of the run [s], on the machine's clock.
        seed: The seed that it was run with.
        scenario: Name of the scenario.
        file: Its file, as the user named it.
        cancelled: What was cancelled, in the order in which it had cleaned up, by the end of the run.
        coverage: What was sampled by `cover` and `record`, in the order in which items were met.
        logs: The last logs, as people read them.
        unobserved: Robots that were moved, and whose contacts nobody observes.
        explanation: What was waited for and carried out when it was decided; None for a run that passed.
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

    def __repr__(self) -> str:
        reason = f" {self.reason!r}" if self.reason else ""
        return f"<Verdict of {self.scenario}: {self.status.value}{reason}>"

    @property
    def passed(self) -> bool:
        """Whether the scenario passed."""
        return self.status is RunStatus.PASSED


def unproved(verdict: Verdict, why: str) -> Verdict:
    """The verdict of a run of which something that was asked for could not be written."""
    if verdict.status is RunStatus.ERROR:
        return verdict
    found = f"{verdict.status.value}, {verdict.reason}" if verdict.reason else verdict.status.value
    return replace(verdict, status=RunStatus.ERROR, reason=f"{why}; the run itself: {found}")
