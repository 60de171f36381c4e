"""Event conditions (7.3.10.4): expressions that are watched, and conditions on time.

A condition is evaluated when it is armed, and then only when it may have changed: when a variable that it read
has (once all changes of the round have taken hold), when time makes it true, or, if it calls an external method,
whose inputs nobody knows, every 20 ms of the run's clock. Where 7.3.10.4 is silent:

- An expression occurs at once if it is true when it is armed, and then whenever it becomes true.
- `rise` and `fall` need a change after the start of the context; `elapsed` occurs once; of a range, the duration
  is drawn once, from the seed.
- As the `if` of an event, `rise`, `fall` and `every` hold in the instants in which they occur, an expression
  is evaluated with the occurrence, and `elapsed` holds from its time on.
- `rise` and `fall` of what names the occurrence compare it with those of the last instant before that had some,
  since the occurrences of one instant have no order. `every` of what names it holds if its time is one of those
  that the occurrence asks for, on the real clock within 20 ms.
- An expression with a label under which nothing has been invoked yet does not hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from random import Random
from typing import NamedTuple, TypeAlias, assert_never

from seoro.lang.plan import Binding, Elapsed, EventCondition, Every, Expression, Fall, Holds, Rise, parts
from seoro.runtime.agenda import TIME_DIGITS, Agenda, Timer, Waiter
from seoro.runtime.environment import Environment, EvaluationError, NotInvoked, Reads
from seoro.runtime.evaluate import evaluate
from seoro.runtime.past import Past
from seoro.runtime.values import HasFields, Range, Value

SHORTEST_PERIOD = 1e-9  # [s]; times are kept to the nanosecond
POLL_PERIOD = 0.02  # [s] of the run's clock

Stop: TypeAlias = Callable[[], None]  # disarms what was armed


class Context(NamedTuple):
    """An event context (7.3.10.4): who listens, and from when on.

    Args:
        start: Its start [s], on the run's clock.
        past: What is past for who listens.
        path: Position in the tree of invocations.
        purpose: Names what is drawn for it.
    """

    start: float
    past: Past
    path: tuple[int, ...]
    purpose: str


class Conditions:
    """The armed conditions of a run.

    Args:
        agenda: Of the run.
        random: Gives a stream of random numbers for a purpose.
        failed: Told of a condition without a value, which is watched no more.
    """

    def __init__(
        self, agenda: Agenda, random: Callable[[str], Random], failed: Callable[[EvaluationError], None]
    ) -> None:
        self._agenda = agenda
        self._random = random
        self._failed = failed
        self._readers: dict[tuple[int, str], dict[_Watch, None]] = {}

    def arm(
        self, condition: EventCondition, environment: Environment, context: Context, occurs: Callable[[], None]
    ) -> Stop:
        """Call `occurs` whenever a condition occurs; at once, if it does when it is armed."""
        match condition:
            case Holds(expression) | Rise(expression) | Fall(expression):
                awaited = not isinstance(condition, Fall)
                watch = _Watch(expression, environment, lambda value: occurs() if value is awaited else None)
                self._watch(watch, context.path)
                if isinstance(condition, Holds) and watch.value:
                    occurs()
                return partial(self._forget, watch)
            case Elapsed():
                try:
                    end = self._end(condition, environment, context)
                except EvaluationError as error:
                    self._failed(error)
                    return _nothing
                return self._at(end, occurs)
            case Every():
                return self._arm_every(condition, environment, context, occurs)
            case _:
                assert_never(condition)

    def fire_after(self, condition: Elapsed, environment: Environment, context: Context, waiter: Waiter) -> None:
        """Fire a waiter at the end of a time; as most waits are for that, with nothing in between."""
        try:
            end = self._end(condition, environment, context)
        except EvaluationError as error:
            self._failed(error)
            return
        if end <= self._agenda.now:
            self._agenda.fire(waiter)
        else:
            self._agenda.at(end, waiter)

    def guard(
        self, condition: EventCondition | None, environment: Environment, context: Context, name: str | None = None
    ) -> tuple[Callable[[Environment], bool], Stop]:
        """What says whether a condition of an event holds when that occurs, given the names then; and its end.

        Args:
            condition: The condition.
            environment: What its names stand for, but for that of the occurrence.
            context: The event context.
            name: The name of the occurrence, if it has one.
        """
        match condition:
            case Rise(expression) | Fall(expression) if name is not None and _names(expression, name):
                changes = _Changes(expression, isinstance(condition, Rise), lambda: self._agenda.instant)
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
                    lambda inside: self._agenda.now >= self._end(condition, inside, context)
                ), _nothing
            case Rise() | Fall() | Every():
                last = [-1]

                def occurs() -> None:
                    last[0] = self._agenda.instant

                return lambda _: last[0] == self._agenda.instant, self.arm(condition, environment, context, occurs)
            case _:
                assert_never(condition)

    def changed(self, holder: HasFields, name: str) -> None:
        """A variable, or what a label stands for, has changed: see, once all changes have taken hold, what that
        means for who read it."""
        for watch in self._readers.get((id(holder), name), ()):
            if not watch.is_due:
                watch.is_due = True
                self._agenda.check(watch.path, partial(self._look_again, watch))

    # -------------------------------------------------------- time

    def _end(self, condition: Elapsed, environment: Environment, context: Context) -> float:
        duration = evaluate(condition.duration, environment)
        if isinstance(duration, Range):
            duration = self._random(context.purpose).uniform(duration.low, duration.high)
        return round(context.start + _seconds(duration, condition.duration), TIME_DIGITS)

    def _arm_every(
        self, condition: Every, environment: Environment, context: Context, occurs: Callable[[], None]
    ) -> Stop:
        try:
            first, period = _first_and_period(condition, environment, context)
        except EvaluationError as error:
            self._failed(error)
            return _nothing
        ticks = _Ticks(self._agenda, first, period, occurs)
        ticks.start()
        return ticks.stop

    def _is_tick(self, condition: Every, environment: Environment, context: Context) -> bool:
        """Whether an instant is the first one at or after a time of `every`."""
        first, period = _first_and_period(condition, environment, context)
        number = math.floor(round((self._agenda.now - first) / period, TIME_DIGITS))
        passed = self._agenda.now - round(first + number * period, TIME_DIGITS)
        return number >= 0 and passed <= (0.0 if self._agenda.is_exact else POLL_PERIOD)

    def _at(self, time: float, act: Callable[[], None]) -> Stop:
        """Do something at a time; at once, if that has come."""
        if time <= self._agenda.now:
            act()
            return _nothing
        timer = Timer(act)
        self._agenda.at(time, timer)
        return partial(setattr, timer, "over", True)

    # -------------------------------------------------------- expressions

    def _safely(self, holds: Callable[[Environment], bool]) -> Callable[[Environment], bool]:
        """The same, where no flow is there to take an exception."""

        def check(environment: Environment) -> bool:
            try:
                return holds(environment)
            except NotInvoked:
                return False
            except EvaluationError as error:
                self._failed(error)
                return False

        return check

    def _watch(self, watch: _Watch, path: tuple[int, ...]) -> None:
        watch.path = path
        watch.value = self._evaluate(watch)

    def _look_again(self, watch: _Watch) -> None:
        watch.is_due = False
        if watch.is_over:
            return
        before, watch.value = watch.value, self._evaluate(watch)
        if watch.value is not before and not watch.is_over:
            watch.turned(watch.value)

    def _evaluate(self, watch: _Watch) -> bool:
        """The value of an expression now; from now on, it is looked at again when what it has read changes."""
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
            watch.poll = Timer(partial(self._look_again, watch))
            self._agenda.at(self._agenda.now + POLL_PERIOD, watch.poll)
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
    """An expression that is watched.

    Args:
        expression: It is true or false.
        environment: What its names stand for.
        turned: Called between rounds with its new value.
    """

    def __init__(self, expression: Expression, environment: Environment, turned: Callable[[bool], None]) -> None:
        self.expression = expression
        self.environment = environment
        self.turned = turned
        self.path: tuple[int, ...] = ()
        self.value = False
        self.reads = Reads()
        self.poll = Timer(_nothing, over=True)
        self.is_due = False  # whether it is going to be looked at again
        self.is_over = False


class _Ticks:
    """The times of `every`.

    Args:
        agenda: Of the run.
        first: The first of them [s].
        period: The time from one to the next [s].
        occurs: Called at each that is not past.
    """

    def __init__(self, agenda: Agenda, first: float, period: float, occurs: Callable[[], None]) -> None:
        self._agenda = agenda
        self._first = first
        self._period = period
        self._occurs = occurs
        self._number = max(0, int((agenda.now - first) / period))
        self._timer = Timer(self._act)

    def start(self) -> None:
        """Occur now, if this is one of the times, and at all that come."""
        if self._due < self._agenda.now:
            self._number += 1
        if self._due == self._agenda.now:
            self._occurs()
            self._number += 1
        self._agenda.at(self._due, self._timer)

    def stop(self) -> None:
        """Occur no more."""
        self._timer.over = True

    @property
    def _due(self) -> float:
        return round(self._first + self._number * self._period, TIME_DIGITS)

    def _act(self) -> None:
        self._occurs()
        while self._due <= self._agenda.now:  # real clocks may have gone on past several
            self._number += 1
        if not self._timer.over:
            self._agenda.at(self._due, self._timer)


class _Changes:
    """What an expression about occurrences has been.

    Args:
        expression: It is true or false of an occurrence.
        awaited: What it has to become.
        instant: Gives the number of the present instant.
    """

    def __init__(self, expression: Expression, awaited: bool, instant: Callable[[], int]) -> None:
        self._expression = expression
        self._awaited = awaited
        self._instant = instant
        self._last = -1  # the last instant with occurrences
        self._now: set[bool] = set()  # what it was in that
        self._before: set[bool] = set()  # what it was in the one with occurrences before

    def check(self, environment: Environment) -> bool:
        """Whether it has changed with an occurrence."""
        value = bool(evaluate(self._expression, environment))
        if self._last != self._instant():
            self._last, self._before, self._now = self._instant(), self._now, set()
        self._now.add(value)
        return value is self._awaited and (not self._awaited) in self._before


def _names(expression: Expression, name: str) -> bool:
    """Whether an expression uses what is bound to a name."""
    pending = [expression]
    while pending:
        part = pending.pop()
        if isinstance(part, Binding) and part.name == name:
            return True
        pending += parts(part)
    return False


def _first_and_period(condition: Every, environment: Environment, context: Context) -> tuple[float, float]:
    """When `every` occurs first, and the time from one occurrence to the next [s]."""
    period = _seconds(evaluate(condition.period, environment), condition.period)
    if period < SHORTEST_PERIOD:
        reason = f"the period of `every` has to be at least 1 ns, and is {period:g} s"
        raise EvaluationError(reason, condition.period.span)
    if condition.offset is None:
        return context.start, period
    return context.start + _seconds(evaluate(condition.offset, environment), condition.offset), period


def _seconds(duration: Value, expression: Expression) -> float:
    """A duration that an expression gave [s]."""
    assert isinstance(duration, int | float)
    if not (math.isfinite(duration) and duration >= 0):
        raise EvaluationError(f"a duration cannot be {duration:g} s", expression.span)
    return duration


def _nothing() -> None:
    """Nothing has to be disarmed."""
