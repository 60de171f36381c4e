"""Events as channels (7.3.10, 7.6.2.5).

An occurrence belongs to an instant; two emissions with equal arguments in one instant are one. A flow that waits
sees every occurrence from the instant on in which it began to wait, except those in its causal past: what it
emitted or consumed itself, and what flows that it was forked from or joined had in theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import count

from seoro.runtime.agenda import Agenda, Flow, Waiter
from seoro.runtime.values import Value, plain


@dataclass(frozen=True)
class Occurrence:
    """One happening of an event; as an event object it has its arguments as fields."""

    number: int
    fields: Mapping[str, Value]


Accepts = Callable[[Occurrence], bool]


@dataclass(eq=False)
class Event:
    """A channel: who waits, and what has happened in the present instant."""

    path: str
    instant: int = -1
    occurrences: list[Occurrence] = field(default_factory=list)  # that have taken hold
    waiters: list[tuple[Waiter, Accepts]] = field(default_factory=list)
    listeners: list[Callable[[], None]] = field(default_factory=list)  # told between rounds, of each occurrence


class Events:
    """All events of a run.

    Args:
        agenda: Orders emissions and waits.
        emitted: Called once for each occurrence, with the event's path and its arguments.
    """

    def __init__(self, agenda: Agenda, emitted: Callable[[str, Mapping[str, Value]], None]) -> None:
        self._agenda = agenda
        self._emitted = emitted
        self._numbers = count()
        self._instant = -1
        self._pending: dict[tuple[int, str], Occurrence] = {}  # of this instant, by event and arguments

    def emit(self, event: Event, arguments: Mapping[str, Value], flow: Flow) -> None:
        """Emit; it takes hold between this round and the next."""
        self._begin_instant(event)
        key = (id(event), repr([(name, plain(value)) for name, value in arguments.items()]))
        occurrence = self._pending.get(key)
        if occurrence is None:
            occurrence = self._pending[key] = Occurrence(next(self._numbers), dict(arguments))
            self._emitted(event.path, arguments)
            self._agenda.emit(lambda: self._take_hold(event, occurrence))
        flow.past_in(self._agenda.instant).add(occurrence.number)

    def arm(self, event: Event, waiter: Waiter, accepts: Accepts) -> None:
        """Let a flow wait; fires at once if the event has happened in this instant, unseen by the flow."""
        self._begin_instant(event)
        event.waiters = [(other, accept) for other, accept in event.waiters if not other.over]
        for occurrence in event.occurrences:
            if self._offer(occurrence, waiter, accepts):
                return
        event.waiters.append((waiter, accepts))

    def _take_hold(self, event: Event, occurrence: Occurrence) -> None:
        event.occurrences.append(occurrence)
        for listener in event.listeners:
            listener()
        event.waiters = [
            (waiter, accepts)
            for waiter, accepts in event.waiters
            if not (waiter.over or waiter.fired or self._offer(occurrence, waiter, accepts))
        ]

    def _offer(self, occurrence: Occurrence, waiter: Waiter, accepts: Accepts) -> bool:
        past = waiter.flow.past_in(self._agenda.instant)
        if occurrence.number in past or not accepts(occurrence):
            return False
        past.add(occurrence.number)
        self._agenda.fire(waiter, occurrence)
        return True

    def _begin_instant(self, event: Event) -> None:
        """Forget what happened in earlier instants: nobody can see it any more."""
        instant = self._agenda.instant
        if self._instant != instant:
            self._instant = instant
            self._pending.clear()
        if event.instant != instant:
            event.instant = instant
            event.occurrences.clear()
