"""Event conditions (7.3.10.4): watched expressions and conditions on time.

A condition is evaluated when it is armed, and again when time may make it true. After a change of a variable that
it read, it is evaluated once all changes of the delta cycle are committed. If it calls an external method with
unknown inputs, it is evaluated every 20 ms of the run's clock. Where 7.3.10.4 is silent:

- An expression occurs at once if it is true when armed, and then whenever it becomes true.
- `rise` and `fall` need a change after the start of the context; `elapsed` occurs once; a duration from a range is
  drawn once, from the seed.
- As the `if` of an event, `rise`, `fall` and `every` hold in the instants in which they occur. An expression is
  evaluated with the occurrence. `elapsed` holds from its time on.
- `rise` and `fall` of an expression that names the occurrence compare with the occurrences of the last instant
  that had any, since occurrences of one instant have no order. `every` that names it holds at the times that the
  occurrence defines, on the real clock within 20 ms.
- An expression with a label that has not been invoked yet does not hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from random import Random
from typing import NamedTuple, TypeAlias, assert_never

from seoro.lang.plan import Binding, Elapsed, EventCondition, Every, Expression, Fall, Holds, Rise, walk
from seoro.runtime.events.ticks import Ticks, first_and_period, seconds
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.kernel.clock import TIME_DIGITS
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.kernel.timers import Timer
from seoro.runtime.values.environment import Environment, EvaluationError, NotInvoked, Reads
from seoro.runtime.values.values import HasFields, Range

POLL_PERIOD = 0.02  # [s] of the run's clock

Stop: TypeAlias = Callable[[], None]  # disarms a condition or a subscription


class EventContext(NamedTuple):
    """An event context (7.3.10.4): a subscriber and the start of its subscription.

    Args:
        start: Its start [s], on the run's clock.
        past: Occurrences that the subscriber must not receive.
        path: Position in the tree of invocations.
        purpose: Purpose of its random draws.
    """

    start: float
    past: CausalPast
    path: tuple[int, ...]
    purpose: Callable[[], str]


class Conditions:
    """The armed conditions of a run.

    Args:
        scheduler: Scheduler of the run.
        random: Returns a stream of random numbers for a purpose.
        failed: Called for a condition without a value, which is then disarmed.
    """

    def __init__(
        self, scheduler: Scheduler, random: Callable[[str], Random], failed: Callable[[EvaluationError], None]
    ) -> None:
        self._scheduler = scheduler
        self._random = random
        self._failed = failed
        self._readers: dict[tuple[int, str], dict[_Watch, None]] = {}

    def arm(
        self,
        condition: EventCondition,
        environment: Environment,
        context: EventContext,
        occurs: Callable[[], None],
    ) -> Stop:
        """Call `occurs` whenever a condition occurs, including now; return the function that disarms it."""
        match condition:
            case Holds(expression) | Rise(expression) | Fall(expression):
                awaited = not isinstance(condition, Fall)
                watch = _Watch(expression, environment, lambda value: occurs() if value is awaited else None)
                watch.path, watch.cause = context.path, context.past.cause
                watch.value = self._evaluate(watch)
                if isinstance(condition, Holds) and watch.value:
                    occurs()
                return partial(self._forget, watch)
            case Elapsed():
                try:
                    end = self.end_of(condition, environment, context)
                except EvaluationError as error:
                    self._failed(error)
                    return _nothing
                return self._at(end, occurs, context.past.cause)
            case Every():
                return self._arm_every(condition, environment, context, occurs)
            case _:
                assert_never(condition)

    def guard(
        self,
        condition: EventCondition | None,
        environment: Environment,
        context: EventContext,
        name: str | None = None,
    ) -> tuple[Callable[[Environment], bool], Stop]:
        """Return a check whether a condition holds for an occurrence, and the function that disarms it.

        Args:
            condition: The condition.
            environment: Environment without the occurrence.
            context: The event context.
            name: Name of the occurrence, if it has one.
        """
        match condition:
            case Rise(expression) | Fall(expression) if name is not None and _names(expression, name):
                changes = _Changes(expression, isinstance(condition, Rise), lambda: self._scheduler.instant)
                return self._safely(changes.check), _nothing
            case Every(period, offset) if name is not None and any(
                part is not None and _names(part, name) for part in (period, offset)
            ):
                return self._safely(lambda inside: self._is_tick(condition, inside, context)), _nothing
            case None:
                return lambda _: True, _nothing
            case Holds(expression):
                return self._safely(lambda inside: bool(evaluate(expression, inside))), _nothing
            case Elapsed():
                return self._safely(
                    lambda inside: self._scheduler.now >= self.end_of(condition, inside, context)
                ), _nothing
            case Rise() | Fall() | Every():
                last = [-1]

                def occurs() -> None:
                    last[0] = self._scheduler.instant

                return lambda _: last[0] == self._scheduler.instant, self.arm(
                    condition, environment, context, occurs
                )
            case _:
                assert_never(condition)

    def changed(self, holder: HasFields, name: str) -> None:
        """Check conditions that read a variable or a label again, once all changes are committed."""
        for watch in self._readers.get((id(holder), name), ()):
            if not watch.is_due:
                watch.is_due = True
                self._scheduler.check(watch.path, partial(self._look_again, watch))

    # -------------------------------------------------------- time

    def end_of(self, condition: Elapsed, environment: Environment, context: EventContext) -> float:
        """Return when a time has elapsed [s]; durations from a range are drawn.

        Raises:
            EvaluationError: The duration is negative or has no value.
        """
        duration = evaluate(condition.duration, environment)
        if isinstance(duration, Range):
            duration = self._random(context.purpose()).uniform(duration.low, duration.high)
        return round(context.start + seconds(duration, condition.duration), TIME_DIGITS)

    def _arm_every(
        self, condition: Every, environment: Environment, context: EventContext, occurs: Callable[[], None]
    ) -> Stop:
        try:
            first, period = first_and_period(condition, environment, context.start)
        except EvaluationError as error:
            self._failed(error)
            return _nothing
        ticks = Ticks(self._scheduler, first, period, occurs, context.past.cause)
        ticks.start()
        return ticks.stop

    def _is_tick(self, condition: Every, environment: Environment, context: EventContext) -> bool:
        """Whether an instant is the first at or after a time of `every`."""
        first, period = first_and_period(condition, environment, context.start)
        number = math.floor(round((self._scheduler.now - first) / period, TIME_DIGITS))
        passed = self._scheduler.now - round(first + number * period, TIME_DIGITS)
        return number >= 0 and passed <= (0.0 if self._scheduler.is_exact else POLL_PERIOD)

    def _at(self, time: float, act: Callable[[], None], cause: int | None) -> Stop:
        """Call a function at a time; now, if it has come.

        Args:
            time: The time [s].
            act: The function.
            cause: Cause of its effects; see `CausalPast`.
        """
        if time <= self._scheduler.now:
            act()
            return _nothing
        timer = Timer(act, cause=cause)
        self._scheduler.act_at(time, timer)
        return partial(setattr, timer, "over", True)

    # -------------------------------------------------------- expressions

    def _safely(self, holds: Callable[[Environment], bool]) -> Callable[[Environment], bool]:
        """Wrap a check so that it reports a missing value, since no task would handle the exception."""

        def check(environment: Environment) -> bool:
            try:
                return holds(environment)
            except NotInvoked:
                return False
            except EvaluationError as error:
                self._failed(error)
                return False

        return check

    def _look_again(self, watch: _Watch) -> None:
        watch.is_due = False
        if watch.is_over:
            return
        before, watch.value = watch.value, self._evaluate(watch)
        if watch.value is not before and not watch.is_over:
            watch.turned(watch.value)

    def _evaluate(self, watch: _Watch) -> bool:
        """Evaluate a watched expression, and register the variables that it reads."""
        reads = Reads()
        try:
            value = bool(evaluate(watch.expression, watch.environment.reading(reads)))
        except NotInvoked:
            value = False
        except EvaluationError as error:
            self._forget(watch)
            self._failed(error)
            return False
        if reads.fields.keys() != watch.reads.fields.keys():
            self._unregister(watch)
            watch.reads = reads
            for key in reads.fields:
                self._readers.setdefault(key, {})[watch] = None
        watch.poll.over = True
        if reads.is_external:
            watch.poll = Timer(partial(self._look_again, watch), cause=watch.cause)
            self._scheduler.act_at(self._scheduler.now + POLL_PERIOD, watch.poll)
        return value

    def _forget(self, watch: _Watch) -> None:
        watch.is_over = watch.poll.over = True
        self._unregister(watch)

    def _unregister(self, watch: _Watch) -> None:
        for key in watch.reads.fields:
            readers = self._readers[key]
            del readers[watch]
            if not readers:
                del self._readers[key]
        watch.reads = Reads()


class _Watch:
    """A watched expression.

    Args:
        expression: A boolean expression.
        environment: Its environment.
        turned: Called between delta cycles with a changed value.
    """

    def __init__(self, expression: Expression, environment: Environment, turned: Callable[[bool], None]) -> None:
        self.expression = expression
        self.environment = environment
        self.turned = turned
        self.path: tuple[int, ...] = ()
        self.cause: int | None = None  # of changes that time brings about; see `CausalPast`
        self.value = False
        self.reads = Reads()
        self.poll = Timer(_nothing, over=True)
        self.is_due = False  # whether a check is scheduled
        self.is_over = False


class _Changes:
    """Values of an expression over occurrences.

    Args:
        expression: A boolean expression that names the occurrence.
        awaited: Value to which it must change.
        instant: Returns the number of the present instant.
    """

    def __init__(self, expression: Expression, awaited: bool, instant: Callable[[], int]) -> None:
        self._expression = expression
        self._awaited = awaited
        self._instant = instant
        self._last = -1  # last instant with occurrences
        self._now: set[bool] = set()  # its values in that instant
        self._before: set[bool] = set()  # its values in the previous instant with occurrences

    def check(self, environment: Environment) -> bool:
        """Whether it has changed with an occurrence."""
        value = bool(evaluate(self._expression, environment))
        if self._last != self._instant():
            self._last, self._before, self._now = self._instant(), self._now, set()
        self._now.add(value)
        return value is self._awaited and (not self._awaited) in self._before


def _names(expression: Expression, name: str) -> bool:
    """Whether an expression uses a bound name."""
    return any(isinstance(part, Binding) and part.name == name for part in walk(expression))


def _nothing() -> None:
    """Disarm nothing."""
