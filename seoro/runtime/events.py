"""Events as channels (7.3.10, 7.6.2.5).

An occurrence belongs to an instant; two emissions with equal arguments in one instant are one. One who listens
hears every occurrence from the instant on in which it began to, except those in its causal past (`past.py`): what
it emitted or consumed itself, and what flows that it was forked from or joined had in theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import count
from weakref import WeakKeyDictionary

from seoro.runtime.agenda import Agenda
from seoro.runtime.past import Past
from seoro.runtime.values import Actor, Struct, Value, plain


@dataclass(frozen=True)
class Occurrence:
    """One happening of an event; as an event object it has its arguments as fields."""

    number: int
    fields: Mapping[str, Value]


@dataclass(eq=False)
class Ear:
    """One who listens to an event.

    Args:
        past: What it must not see (again).
        hear: Called between rounds, when no flow is there to take an exception; says whether the occurrence counts
            for it, and so is in its past from then on.
    """

    past: Past
    hear: Callable[[Occurrence], bool]
    over: bool = False  # whether it listens no more

    def stop(self) -> None:
        """Listen no more."""
        self.over = True


@dataclass(eq=False)
class Event:
    """A channel: who listens, and what has happened in the present instant."""

    path: str
    instant: int = -1
    occurrences: list[Occurrence] = field(default_factory=list)  # that have taken hold
    derived: int = -1  # the last instant in which what it is derived from has occurred
    ears: list[Ear] = field(default_factory=list)


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
        self._pending: dict[tuple[Event, str], Occurrence] = {}  # of this instant, by event and arguments
        self._of_objects: WeakKeyDictionary[Struct | Actor, dict[str, Event]] = WeakKeyDictionary()

    def of_object(self, holder: Struct | Actor, name: str) -> Event:
        """The channel of an event of a struct or an actor."""
        shown = holder.name if isinstance(holder, Actor) else holder.type.name
        return self._of_objects.setdefault(holder, {}).setdefault(name, Event(f"{shown}.{name}"))

    def emit(self, event: Event, arguments: Mapping[str, Value], past: Past) -> None:
        """Emit; it takes hold between this round and the next, and is in the past of who emits."""
        self._begin_instant(event)
        shown = repr([(name, plain(value)) for name, value in arguments.items()])
        occurrence = self._pending.get((event, shown))
        if occurrence is None:
            occurrence = self._pending[event, shown] = Occurrence(next(self._numbers), dict(arguments))
            self._emitted(event.path, arguments)
            self._agenda.emit((event.path, shown), lambda: self._take_hold(event, occurrence))
        past.of(self._agenda.instant).add(occurrence.number)

    def derive(self, event: Event) -> Occurrence:
        """An occurrence of a derived event, for the one in whose context it is; recorded once for each instant."""
        if event.derived != self._agenda.instant:
            event.derived = self._agenda.instant
            self._emitted(event.path, {})
        return Occurrence(next(self._numbers), {})

    def listen(self, event: Event, ear: Ear) -> None:
        """Listen from now on, until the ear is over; what has happened in this instant is heard at once."""
        self._begin_instant(event)
        event.ears = [other for other in event.ears if not other.over]
        event.ears.append(ear)
        for occurrence in event.occurrences:
            self._offer(occurrence, ear)

    def _take_hold(self, event: Event, occurrence: Occurrence) -> None:
        event.occurrences.append(occurrence)
        for ear in tuple(event.ears):
            self._offer(occurrence, ear)

    def _offer(self, occurrence: Occurrence, ear: Ear) -> None:
        past = ear.past.of(self._agenda.instant)
        if not ear.over and occurrence.number not in past and ear.hear(occurrence):
            past.add(occurrence.number)

    def _begin_instant(self, event: Event) -> None:
        """Forget what happened in earlier instants: nobody can see it any more."""
        instant = self._agenda.instant
        if self._instant != instant:
            self._instant = instant
            self._pending.clear()
        if event.instant != instant:
            event.instant = instant
            event.occurrences.clear()
