"""Which events of which instances a reference means (7.3.10), and when they occurred."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

from seoro.lang.plan import (
    DeclaredEvent,
    Event,
    EventReference,
    EventSpecification,
    LabelEvent,
    MemberEvent,
    OnEvent,
    PhaseEvent,
    Plan,
)
from seoro.runtime.accept.findings import Undecided
from seoro.runtime.accept.history import Happening, History, Mark
from seoro.runtime.accept.world import Instance, World
from seoro.runtime.environment import Environment
from seoro.runtime.values import Actor, HasFields, Struct

_NESTING = 64  # of references and of events that are derived from one another; more is refused by the runtime


@dataclass(frozen=True, eq=False)
class Channel:
    """An event of an instance, while a reference means it.

    Args:
        of: Number of the instance.
        name: What that calls it.
        environment: What names stand for in its scope.
        declared: Its declaration; None of those that are predefined.
        start: From when on the reference means it.
        end: Up to which record.
    """

    of: int
    name: str
    environment: Environment
    declared: Event | None
    start: Mark
    end: float


@dataclass(eq=False)
class Channels:
    """Finds events.

    Args:
        plan: The plan.
        history: The trace.
        world: Its values.
    """

    plan: Plan
    history: History
    world: World

    def at(self, of: int, name: str, t: float) -> Sequence[Happening]:
        """The occurrences of an event in an instant."""
        return self.between(of, name, t, t)

    def between(self, of: int, name: str, since: float, until: float) -> Sequence[Happening]:
        """The occurrences of an event from one instant to another, both included."""
        found = self.history.events.get((of, name), [])
        first = bisect_left(found, since, key=lambda each: each.mark.t)
        last = bisect_right(found, until, key=lambda each: each.mark.t)
        return found[first:last]

    def sources(
        self, specification: EventSpecification, environment: Environment, start: Mark, t: float, depth: int = 0
    ) -> tuple[set[int], bool]:
        """The records of what may have met a specification in an instant, and whether nothing else may.

        Raises:
            Undecided: The trace does not tell.
        """
        if not isinstance(specification, OnEvent) or depth > _NESTING:
            return set(), False
        found: set[int] = set()
        is_all = True
        for channel in self.resolve(specification.event, environment, start):
            emitted = (each for each in self.at(channel.of, channel.name, t) if not each.is_derived)
            found.update(each.mark.seq for each in emitted if each.mark.seq < channel.end)
            derived = channel.declared.specification if channel.declared is not None else None
            if derived is not None:
                more, is_rest = self.sources(derived, channel.environment, channel.start, t, depth + 1)
                found |= more
                is_all = is_all and is_rest
        return found, is_all

    def resolve(
        self, reference: EventReference, environment: Environment, start: Mark, end: float = float("inf")
    ) -> Iterator[Channel]:
        """What a reference means from a place of the trace on.

        Raises:
            Undecided: The trace does not tell.
        """
        match reference:
            case DeclaredEvent(name):
                holder = environment.instance
                declared = next((event for event in self.events_of(holder) if event.name == name), None)
                yield Channel(self._number(holder), name, environment, declared, start, end)
            case PhaseEvent(label, phase):
                name = f"{label}.{phase.value}" if label is not None else phase.value
                yield Channel(self._number(environment.instance), name, environment, None, start, end)
            case MemberEvent(base, event):
                found = cast(HasFields, self.world.value(base, environment, start.seq))
                yield from self.resolve(event, self.world.scope_of(found, environment), start, end)
            case LabelEvent(label, event):
                yield from self._of_label(label, event, environment, start, end)

    def _of_label(
        self, label: str, event: EventReference, environment: Environment, start: Mark, end: float
    ) -> Iterator[Channel]:
        """Of what was invoked last under a label, and of what is invoked under it later."""
        holder = environment.instance
        if not isinstance(holder, Instance):
            raise Undecided(f"nothing has the label `{label}`")
        invoked = holder.labels.get(label, [])
        for number, instance in enumerate(invoked):
            following = invoked[number + 1].seq if number + 1 < len(invoked) else float("inf")
            if following <= start.seq or instance.seq >= end:
                continue
            begin = max(start, Mark(instance.seq, instance.told["t"]))
            yield from self.resolve(event, instance.environment, begin, min(end, following))

    def _number(self, holder: HasFields) -> int:
        number = self.world.number(holder)
        if number is None:
            raise Undecided("the trace does not tell of which instance an event is")
        return number

    def events_of(self, holder: HasFields) -> Sequence[Event]:
        """The events that something declares."""
        match holder:
            case Instance():
                return holder.declaration.events
            case Struct() | Actor():
                objects = self.plan.objects
                return next((objects[name].events for name in holder.types if name in objects), ())
            case _:
                return ()
