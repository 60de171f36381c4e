"""Declared and predefined events: the channels of instances, structs and actors (7.3.10, 7.6.2.5).

Emissions with equal arguments in one instant are one occurrence. A derived event (`event e is ...`) has no channel
of its own for its source: it occurs in the context of each use.
"""

from __future__ import annotations

from collections.abc import Mapping
from weakref import ReferenceType, WeakKeyDictionary, ref

from seoro.lang.plan import OwnEvent, Phase, phase_name
from seoro.runtime.events.occurrence import APPLICATION
from seoro.runtime.instances.instances import Composed, Instance
from seoro.runtime.kernel.channel import Channel, Occurrence
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.trace.records import Trace
from seoro.runtime.values.values import Actor, Struct, Value, plain


class Event(Channel):
    """The channel of one event of one holder.

    Args:
        scheduler: Scheduler of the run.
        path: Its name in the trace.
        holder: Object that has the event.
        name: Its name within the holder; of a labelled member, `label.end`.
    """

    __slots__ = ("derived", "holder", "number", "short_name")

    def __init__(self, scheduler: Scheduler, path: str, holder: ReferenceType[object], name: str) -> None:
        super().__init__(scheduler, path)
        self.holder = holder
        self.short_name = name
        self.derived = -1  # last instant in which its source has occurred
        self.number: int | None = None  # of the record of that occurrence


class Events:
    """The channels of a run.

    Args:
        scheduler: Scheduler of the run.
        trace: Trace of the run.
    """

    def __init__(self, scheduler: Scheduler, trace: Trace) -> None:
        self._scheduler = scheduler
        self._trace = trace
        self._of_objects: WeakKeyDictionary[Struct | Actor, dict[str, Event]] = WeakKeyDictionary()

    def phase(self, instance: Instance | Composed, label: str | None, phase: Phase) -> Event:
        """Return the channel of a predefined event of a labelled member, or of the instance itself."""
        return self._of_instance(instance, phase_name(label, phase))

    def declared(self, holder: Instance | Struct | Actor, name: str) -> Event:
        """Return the channel of a declared event."""
        if isinstance(holder, Instance):
            return self._of_instance(holder, name)
        channels = self._of_objects.setdefault(holder, {})
        if name not in channels:
            shown = holder.name if isinstance(holder, Actor) else holder.type.name
            channels[name] = Event(self._scheduler, f"{shown}.{name}", ref(holder), name)
        return channels[name]

    def own(self, instance: Instance, reference: OwnEvent) -> Event:
        """Return the channel of an event referenced within its scenario or action."""
        return self._of_instance(instance, reference.name)

    def _of_instance(self, instance: Instance | Composed, name: str) -> Event:
        channel = instance.channels.get(name)
        if channel is None:
            channel = instance.channels[name] = Event(
                self._scheduler, f"{instance.path}.{name}", ref(instance), name
            )
        assert isinstance(channel, Event)
        return channel

    def emit(self, event: Event, arguments: Mapping[str, Value], past: CausalPast) -> None:
        """Emit an event; it is delivered after this delta cycle, and is in the past of the emitter."""
        cause = past.cause
        occurrence = event.send(arguments, past, _key(arguments))
        if occurrence is not None:
            occurrence.cause = self._trace.occurrence(event, arguments, cause)

    def emit_outside(self, event: Event, arguments: Mapping[str, Value]) -> None:
        """Emit an event of the application; it is in no past."""
        occurrence = event.send(arguments, CausalPast(), _key(arguments))
        if occurrence is not None:
            occurrence.cause = self._trace.occurrence(event, arguments, None, origin=APPLICATION)

    def derive(self, event: Event) -> Occurrence:
        """Return an occurrence of a derived event for one use; recorded once per instant."""
        if event.derived != self._scheduler.instant:
            event.derived = self._scheduler.instant
            event.number = self._trace.occurrence(event, {}, self._scheduler.cause, is_derived=True)
        self._scheduler.cause = event.number
        return Occurrence({})


def _key(arguments: Mapping[str, Value]) -> str:
    """Return a key that distinguishes occurrences with different arguments."""
    return repr([(name, plain(value)) for name, value in arguments.items()]) if arguments else ""
