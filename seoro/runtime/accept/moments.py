"""Moments at which an event specification is met (7.3.10.4), for a subscriber from a place of the trace on.

A moment may be a span of time if a duration was drawn from a range. It is *sure* if the specification was
certainly met then. Others are possible as far as the trace shows: changes of variables in a row may have been
committed together.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import assert_never

from seoro.lang import plan
from seoro.runtime.accept.channels import Channel, Channels, Received
from seoro.runtime.accept.findings import Undecided
from seoro.runtime.accept.history import TIME_DIGITS, LoggedEvent, Mark, Node
from seoro.runtime.accept.instances import Holder, TimedFields
from seoro.runtime.accept.pasts import Pasts
from seoro.runtime.accept.world import NothingInvoked, World, has_labels
from seoro.runtime.values.environment import Environment, Reads
from seoro.runtime.values.values import Range

_MOST = 100_000  # moments of one subscriber; more would take too long
_NESTING = 64  # of derived events; the runtime refuses more


@dataclass(frozen=True)
class Moment:
    """A moment at which a specification was met.

    Args:
        first: Earliest time [s].
        last: Latest time [s].
        sure: Whether it was certainly met.
        occurrence: Emitted event, if any.
    """

    first: float
    last: float
    sure: bool
    occurrence: LoggedEvent | None = None

    @property
    def records(self) -> tuple[int, ...]:
        """Record of the emitted event, if any."""
        return (self.occurrence.mark.seq,) if self.occurrence is not None else ()


@dataclass(frozen=True, eq=False)
class Listening:
    """A subscriber.

    Args:
        start: Start of the event context.
        limit: Last time of interest [s].
        environment: Environment of the specification.
        node: Behavior whose causal past at the start it has.
        receives_until: Time until which it certainly receives [s]; it may have ended before in that instant.
        armed: Start of the event's existence; None if from the start on.
    """

    start: Mark
    limit: float
    environment: Environment
    node: Node
    receives_until: float
    armed: Mark | None = None

    @property
    def since(self) -> Mark:
        """First place at which it may be met."""
        return self.armed or self.start


@dataclass(eq=False)
class Moments:
    """Finds moments.

    Args:
        world: The trace, with its values.
        channels: Resolves event references.
        pasts: Finds causal pasts.
    """

    world: World
    channels: Channels
    pasts: Pasts

    def __post_init__(self) -> None:
        self.received = Received(self.world.plan)  # collects received derived events

    def of(self, specification: plan.EventSpecification, listening: Listening, depth: int = 0) -> list[Moment]:
        """Return all moments within an event context, in the order of time.

        Raises:
            Undecided: The trace lacks the data.
        """
        try:
            found = list(self._of(specification, listening, depth))
        except Undecided:
            self.received.give_up(specification)
            raise
        return sorted(found, key=lambda moment: (moment.first, moment.last))

    def _of(self, specification: plan.EventSpecification, listening: Listening, depth: int) -> Iterator[Moment]:
        if depth > _NESTING:
            raise Undecided("derived events are nested too deeply")
        if isinstance(specification, plan.OnEvent):
            occurrences = self._occurrences(specification.event, listening, depth)
            yield from self._guarded(specification, listening, occurrences, depth)
        else:
            yield from self._of_condition(specification, listening)

    # -------------------------------------------------------- events

    def _occurrences(self, reference: plan.EventReference, listening: Listening, depth: int) -> Iterator[Moment]:
        for channel in self.channels.resolve(reference, listening.environment, listening.since):
            yield from self._emitted(channel, listening)
            declared = channel.declared
            if declared is not None and declared.specification is not None:
                inside = replace(listening, armed=channel.start, environment=channel.environment)
                for moment in self.of(declared.specification, inside, depth + 1):
                    for meant in self._while_meant(channel, moment):
                        self.received.add(channel.of, channel.name, meant.first, meant.last)
                        is_sure = (
                            meant.sure and meant.first == meant.last and meant.first < listening.receives_until
                        )
                        if is_sure and self.world.history.is_exact:
                            self.received.due[channel.of, channel.name, meant.first] = None
                        yield replace(meant, occurrence=None)

    def _while_meant(self, channel: Channel, moment: Moment) -> Iterator[Moment]:
        """Yield a moment if the reference resolves to the event then; possibly, in the instant of a change."""
        if channel.end == math.inf:
            yield moment
            return
        end = self.world.history.records[int(channel.end)]["t"]
        if moment.first <= end:
            yield moment if moment.last < end else replace(moment, sure=False)

    def _emitted(self, channel: Channel, listening: Listening) -> Iterator[Moment]:
        start, past = listening.start, None
        for occurrence in self.channels.between(channel.of, channel.name, channel.start.t, listening.limit):
            seq, t = occurrence.mark
            if occurrence.is_derived or seq > channel.end:
                continue
            if t == start.t:
                past = past or self.pasts.before(listening.node, start)
                if seq in past.surely:
                    continue
                yield Moment(t, t, seq not in past.perhaps, occurrence)
            else:
                yield Moment(t, t, True, occurrence)

    def _guarded(
        self, specification: plan.OnEvent, listening: Listening, occurrences: Iterator[Moment], depth: int
    ) -> Iterator[Moment]:
        """Yield the occurrences for which the condition of an event holds."""
        match specification.condition:
            case None:
                yield from occurrences
            case plan.Holds(expression):
                for moment in occurrences:
                    yield from self._if_holds(expression, specification.name, listening, moment)
            case plan.Elapsed(duration):
                low, high = self._seconds(duration, listening)
                for moment in occurrences:
                    if moment.last >= round(listening.start.t + low, TIME_DIGITS):
                        is_sure = moment.first >= round(listening.start.t + high, TIME_DIGITS)
                        yield replace(moment, sure=moment.sure and is_sure)
            case plan.Rise() | plan.Fall() | plan.Every() as condition:
                turns = self.of(condition, listening, depth + 1)
                for moment in occurrences:
                    meeting = [turn for turn in turns if turn.first <= moment.last and moment.first <= turn.last]
                    if meeting:
                        is_sure = any(turn.sure and turn.first == turn.last for turn in meeting)
                        yield replace(moment, sure=moment.sure and is_sure)
            case _:
                assert_never(specification.condition)

    def _if_holds(
        self, expression: plan.Expression, name: str | None, listening: Listening, moment: Moment
    ) -> Iterator[Moment]:
        """Yield a moment if a condition holds then; the condition sees the occurrence by its name."""
        environment = listening.environment
        if name is not None:
            environment = self.named(name, moment, environment)
        if moment.first != moment.last:
            yield replace(moment, sure=False)
            return
        begin = max((listening.start.seq, *moment.records))
        values = [self._holds(expression, environment, seq) for seq in self._states(begin, moment.first)]
        if any(values):
            yield replace(moment, sure=moment.sure and all(values))

    def named(self, name: str, moment: Moment, environment: Environment) -> Environment:
        """Return an environment in which a name means the occurrence of a moment."""
        occurrence = moment.occurrence
        arguments = self.world.arguments.get(occurrence.mark.seq, {}) if occurrence is not None else {}
        return environment.bind(**{name: Holder((), arguments)})

    def _states(self, begin: int, t: float) -> list[int]:
        """Return places of an instant with possibly different values of variables, from a record on."""
        records = self.world.history.records
        first = max(begin, bisect_left(records, t, key=lambda record: record["t"]))
        places = [first + 1]
        for seq in range(first, len(records)):
            if records[seq]["t"] > t or len(places) > 50:
                break
            if records[seq]["kind"] in ("variable", "instance"):
                places.append(seq + 1)
        return places

    def values_at(self, expression: plan.Expression, environment: Environment, t: float) -> set[bool]:
        """Return the possible values of a condition in an instant.

        Raises:
            Undecided: The trace lacks the data.
        """
        states = self._states(0, t)
        return {self._holds(expression, environment, seq) for seq in (states[0] - 1, *states)}

    def _holds(self, expression: plan.Expression, environment: Environment, seq: int) -> bool:
        try:
            return bool(self.world.value(expression, environment, seq))
        except NothingInvoked:
            return False

    # -------------------------------------------------------- conditions

    def _of_condition(self, condition: plan.EventCondition, listening: Listening) -> Iterator[Moment]:
        match condition:
            case plan.Holds(expression):
                yield from self._turns(expression, True, listening, counts_from_start=True)
            case plan.Rise(expression):
                yield from self._turns(expression, True, listening, counts_from_start=False)
            case plan.Fall(expression):
                yield from self._turns(expression, False, listening, counts_from_start=False)
            case plan.Elapsed(duration):
                low, high = self._seconds(duration, listening)
                start, since, reached = listening.start.t, listening.since.t, self.world.history.reached
                yield Moment(max(reached(start + low), since), max(reached(start + high), since), True)
            case plan.Every():
                yield from self._ticks(condition, listening)
            case _:
                assert_never(condition)

    def _seconds(self, expression: plan.Expression, listening: Listening) -> tuple[float, float]:
        found = self.world.value(expression, listening.environment, listening.start.seq)
        low, high = (found.low, found.high) if isinstance(found, Range) else (found, found)
        if not all(
            isinstance(bound, int | float) and math.isfinite(bound) and bound >= 0 for bound in (low, high)
        ):
            raise Undecided(f"`{expression.span.text}` is not a duration")
        return float(low), float(high)  # type: ignore[arg-type] # numbers

    def _ticks(self, every: plan.Every, listening: Listening) -> Iterator[Moment]:
        period, _ = self._seconds(every.period, listening)
        offset = self._seconds(every.offset, listening)[0] if every.offset is not None else 0.0
        first = listening.start.t + offset
        if period < 10**-TIME_DIGITS:
            raise Undecided(f"`{every.span.text}` has no period")
        last = -math.inf
        for number in range(_MOST):
            t = self.world.history.reached(first + number * period)
            if t > listening.limit:
                return
            if t > last and t >= listening.since.t:
                yield Moment(t, t, True)
            last = t
        raise Undecided(f"`{every.span.text}` occurs more than {_MOST:,} times")

    # -------------------------------------------------------- expressions

    def _turns(
        self, expression: plan.Expression, awaited: bool, listening: Listening, *, counts_from_start: bool
    ) -> Iterator[Moment]:
        """Yield the moments at which an expression becomes true, or false."""
        last: bool | None = None  # certain value before
        begun = self._values_before(expression, listening)
        for number, (t, value, is_sure) in enumerate(self._values(expression, listening)):
            if number > _MOST:
                raise Undecided(f"`{expression.span.text}` changes more than {_MOST:,} times")
            if last is None and (value is awaited) is not counts_from_start and (not value) in begun:
                yield Moment(t, t, False)
            if value is awaited and (last is not awaited if last is not None else counts_from_start):
                yield Moment(t, t, is_sure)
            if is_sure or last is None:
                last = value

    def _values_before(self, expression: plan.Expression, listening: Listening) -> set[bool]:
        """Return the values of an expression in the instant of the start, before that. Of invocations in the same
        delta cycle, the subscriber sees the earlier state."""
        if not has_labels(expression, self.world.plan.methods):
            return set()
        places = self.world.instances_before(*listening.since)
        return {self._holds(expression, listening.environment, seq) for seq in places}

    def _values(self, expression: plan.Expression, listening: Listening) -> Iterator[tuple[float, bool, bool]]:
        """Yield possible changes of an expression: time, value, and whether it is certain."""
        (seq, t), last = listening.since, None
        depends_on_labels = has_labels(expression, self.world.plan.methods)
        while t <= listening.limit:
            reads = Reads()
            try:
                value = bool(self.world.value(expression, listening.environment, seq, reads))
            except NothingInvoked:
                value = False
            following = [
                place
                for (_, name), holder in reads.fields.items()
                if isinstance(holder.fields, TimedFields)
                and (place := holder.fields.next_change(name, seq)) is not None
            ]
            if depends_on_labels:
                following += self.world.next_instance(seq)
            if not following:
                yield t, value, True
                return
            place = min(following)
            yield t, value, last is None or not self.world.history.may_be_one(last, place)
            seq, t, last = place + 1, self.world.history.records[place]["t"], place
