"""The times at which `every` occurs (7.3.10.4)."""

from __future__ import annotations

import math
from collections.abc import Callable

from seoro.lang.plan import Every, Expression
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.kernel.clock import TIME_DIGITS
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.timers import Timer
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.values import Value

SHORTEST_PERIOD = 1e-9  # [s]; times are kept to the nanosecond


class Ticks:
    """Timer of `every`.

    Args:
        scheduler: Scheduler of the run.
        first: First time [s].
        period: Period [s].
        occurs: Called at each time that is not past.
        cause: Cause of its effects; see `CausalPast`.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        first: float,
        period: float,
        occurs: Callable[[], None],
        cause: int | None = None,
    ) -> None:
        self._scheduler = scheduler
        self._first = first
        self._period = period
        self._occurs = occurs
        self._number = max(0, int((scheduler.now - first) / period))
        self._timer = Timer(self._act, cause=cause)

    def start(self) -> None:
        """Occur now, if it is a time of `every`, and at all later ones."""
        if self._due < self._scheduler.now:
            self._number += 1
        if self._due == self._scheduler.now:
            self._occurs()
            self._number += 1
        self._scheduler.act_at(self._due, self._timer)

    def stop(self) -> None:
        """Stop occurring."""
        self._timer.over = True

    @property
    def _due(self) -> float:
        return round(self._first + self._number * self._period, TIME_DIGITS)

    def _act(self) -> None:
        self._occurs()
        while self._due <= self._scheduler.now:  # real clocks may have passed several
            self._number += 1
        if not self._timer.over:
            self._scheduler.act_at(self._due, self._timer)


def first_and_period(condition: Every, environment: Environment, start: float) -> tuple[float, float]:
    """Return the first time of `every`, and its period [s].

    Args:
        condition: The condition.
        environment: Its environment.
        start: Start of the event context [s].

    Raises:
        EvaluationError: One has no value or is invalid.
    """
    period = seconds(evaluate(condition.period, environment), condition.period)
    if period < SHORTEST_PERIOD:
        reason = f"invalid period of `every`: expected at least 1 ns, found {period:g} s"
        raise EvaluationError(reason, condition.period.span)
    if condition.offset is None:
        return start, period
    return start + seconds(evaluate(condition.offset, environment), condition.offset), period


def seconds(duration: Value, expression: Expression) -> float:
    """Check a duration, and return it [s].

    Raises:
        EvaluationError: It is negative or not finite.
    """
    assert isinstance(duration, int | float)
    if not (math.isfinite(duration) and duration >= 0):
        raise EvaluationError(f"invalid duration: expected at least 0 s, found {duration:g} s", expression.span)
    return duration
