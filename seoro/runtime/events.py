"""Events as channels (7.3.10, 7.6.2.5).

An occurrence belongs to an instant; two emissions with equal arguments in one instant are one. One who listens
hears every occurrence from the instant on in which it began to, except those in its causal past (`past.py`): what
it emitted or consumed itself, and what flows that it was forked from or joined had in theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count
from typing import Protocol
from weakref import ReferenceType, WeakKeyDictionary, ref

from seoro.lang import frozen
from seoro.runtime.agenda import Agenda
from seoro.runtime.past import Past
from seoro.runtime.values import Actor, Struct, Value, plain


class Occurrence(frozen.Value):
    """One happening of an event; as an event object it has its arguments as fields."""

    number: int
    fields: Mapping[str, Value]


class Ear:
    """One who listens to an event.

    Args:
        past: What it must not see (again).
        hear: Called between rounds, when no flow is there to take an exception; says whether the occurrence counts
            for it, and so is in its past from then on.
    """

    __slots__ = ("_event", "hear", "over", "past")

    def __init__(self, past: Past, hear: Callable[[Occurrence], bool]) -> None:
        self.past = past
        self.hear = hear
        self.over = False  # whether it listens no more
        self._event: Event | None = None  # that it listens to

    def listen(self, event: Event) -> None:
        """Listen to an event from now on."""
        self._event = event
        event.ears[self] = None

    def stop(self) -> None:
        """Listen no more."""
        self.over = True
        if self._event is not None:
            del self._event.ears[self]
            self._event = None


class Event:
    """A channel: who listens, and what has happened in the present instant.

    Args:
        path: What people call it.
        holder: The instance that has it.
        name: What that calls it; of a labelled member, `label.end`.
    """

    __slots__ = ("derived", "ears", "holder", "instant", "name", "occurrences", "path", "pending")

    def __init__(self, path: str, holder: ReferenceType[object], name: str) -> None:
        self.path = path
        self.holder = holder
        self.name = name
        self.instant = -1
        self.pending: dict[str, Occurrence] = {}  # of this instant, by their arguments
        self.occurrences: list[Occurrence] = []  # those that have taken hold
        self.derived = -1  # the last instant in which what it is derived from has occurred
        self.ears: dict[Ear, None] = {}


class Emitted(Protocol):
    """Told once of each occurrence."""

    def __call__(self, event: Event, arguments: Mapping[str, Value], *, is_derived: bool) -> None:
        """It has occurred; `is_derived` says that what it is declared to be has, and that nobody emitted it."""
        ...


class Events:
    """All events of a run.

    Args:
        agenda: Orders emissions and waits.
        emitted: Called once for each occurrence.
    """

    def __init__(self, agenda: Agenda, emitted: Emitted) -> None:
        self._agenda = agenda
        self._emitted = emitted
        self._numbers = count()
        self._of_objects: WeakKeyDictionary[Struct | Actor, dict[str, Event]] = WeakKeyDictionary()

    def of_object(self, holder: Struct | Actor, name: str) -> Event:
        """The channel of an event of a struct or an actor."""
        shown = holder.name if isinstance(holder, Actor) else holder.type.name
        channel = Event(f"{shown}.{name}", ref(holder), name)
        return self._of_objects.setdefault(holder, {}).setdefault(name, channel)

    def emit(self, event: Event, arguments: Mapping[str, Value], past: Past) -> None:
        """Emit; it takes hold between this round and the next, and is in the past of who emits."""
        self._begin_instant(event)
        shown = repr([(name, plain(value)) for name, value in arguments.items()]) if arguments else ""
        occurrence = event.pending.get(shown)
        if occurrence is None:
            occurrence = event.pending[shown] = Occurrence(next(self._numbers), dict(arguments))
            self._emitted(event, arguments, is_derived=False)
            self._agenda.emit((event.path, shown), lambda: self._take_hold(event, occurrence))
        past.add(occurrence.number, self._agenda.instant)

    def derive(self, event: Event) -> Occurrence:
        """An occurrence of a derived event, for the one in whose context it is; recorded once for each instant."""
        if event.derived != self._agenda.instant:
            event.derived = self._agenda.instant
            self._emitted(event, {}, is_derived=True)
        return Occurrence(next(self._numbers), {})

    def listen(self, event: Event, ear: Ear) -> None:
        """Listen from now on, until the ear is over; what has happened in this instant is heard at once."""
        self._begin_instant(event)
        ear.listen(event)
        for occurrence in event.occurrences:
            self._offer(occurrence, ear)

    def _take_hold(self, event: Event, occurrence: Occurrence) -> None:
        event.occurrences.append(occurrence)
        for ear in tuple(event.ears):
            self._offer(occurrence, ear)

    def _offer(self, occurrence: Occurrence, ear: Ear) -> None:
        instant = self._agenda.instant
        if not ear.over and not ear.past.has(occurrence.number, instant) and ear.hear(occurrence):
            ear.past.add(occurrence.number, instant)

    def _begin_instant(self, event: Event) -> None:
        """Forget what happened in earlier instants: nobody can see it any more."""
        instant = self._agenda.instant
        if event.instant != instant:
            event.instant = instant
            event.pending.clear()
            event.occurrences.clear()
