"""Resolution of event references (7.3.10) to events of instances, and their occurrences.

Without a subscriber that is met, a derived event does not occur (7.3.10.4). Subscribers are tracked where a rule
computes when a specification is met. Events with other possible subscribers are not decided.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import cast

from seoro.lang import plan as plan_
from seoro.runtime.accept.findings import Undecided
from seoro.runtime.accept.history import LoggedEvent, Mark
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.world import World
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import HasFields

_NESTING = 64  # of references and derived events; the runtime refuses more


@dataclass(frozen=True, eq=False)
class Channel:
    """An event of an instance, during the time in which a reference resolves to it.

    Args:
        of: Number of the instance.
        name: Name of the event in the instance.
        environment: Environment of its scope.
        declared: Its declaration; None for predefined events.
        start: Start of that time.
        end: Last record of that time.
    """

    of: int
    name: str
    environment: Environment
    declared: plan_.Event | None
    start: Mark
    end: float


@dataclass(eq=False)
class Channels:
    """Resolves event references.

    Args:
        world: The trace, with its values.
    """

    world: World

    def at(self, of: int, name: str, t: float) -> Sequence[LoggedEvent]:
        """Return the occurrences of an event in an instant."""
        return self.between(of, name, t, t)

    def between(self, of: int, name: str, since: float, until: float) -> Sequence[LoggedEvent]:
        """Return the occurrences of an event between two instants, inclusive."""
        found = self.world.history.events.get((of, name), [])
        first = bisect_left(found, since, key=lambda each: each.mark.t)
        last = bisect_right(found, until, key=lambda each: each.mark.t)
        return found[first:last]

    def sources(
        self,
        specification: plan_.EventSpecification,
        environment: Environment,
        start: Mark,
        t: float,
        depth: int = 0,
    ) -> tuple[set[int], bool]:
        """Return the records that may have met a specification in an instant, and whether the list is complete.

        Raises:
            Undecided: The trace lacks the data.
        """
        if not isinstance(specification, plan_.OnEvent) or depth > _NESTING:
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
        self, reference: plan_.EventReference, environment: Environment, start: Mark, end: float = float("inf")
    ) -> Iterator[Channel]:
        """Yield the events that a reference resolves to from a record on.

        Raises:
            Undecided: The trace lacks the data.
        """
        match reference:
            case plan_.DeclaredEvent(name=name) | plan_.PhaseEvent(name=name):
                holder = environment.instance
                declared = self.event_of(holder, name) if isinstance(reference, plan_.DeclaredEvent) else None
                yield Channel(self._number(holder), name, environment, declared, start, end)
            case plan_.MemberEvent(base, event):
                found = cast(HasFields, self.world.value(base, environment, start.seq))
                yield from self.resolve(event, self.world.scope_of(found, environment), start, end)
            case plan_.LabelEvent(label, event):
                yield from self._of_label(label, event, environment, start, end)

    def _of_label(
        self, label: str, event: plan_.EventReference, environment: Environment, start: Mark, end: float
    ) -> Iterator[Channel]:
        """Yield the events of the last invocation under a label, and of later ones."""
        holder = environment.instance
        if not isinstance(holder, Instance):
            raise Undecided(f"no behavior with the label `{label}`")
        invoked = holder.labels.get(label, [])
        for number, instance in enumerate(invoked):
            following = invoked[number + 1].seq if number + 1 < len(invoked) else float("inf")
            if following <= start.seq or instance.seq >= end:
                continue
            begin = max(start, Mark(instance.seq, instance.recorded["t"]))
            yield from self.resolve(event, instance.environment, begin, min(end, following))

    def _number(self, holder: HasFields) -> int:
        number = self.world.number(holder)
        if number is None:
            raise Undecided("the trace does not identify the instance of an event")
        return number

    def event_of(self, holder: HasFields, name: str) -> plan_.Event | None:
        """Return an event that a holder declares; None if unknown."""
        declared = self.world.declaration_of(holder)
        events = declared.events if declared is not None else ()
        return next((event for event in events if event.name == name), None)


_ROUNDING = 1e-9  # [s]


@dataclass(eq=False)
class Received:
    """Received derived events.

    Args:
        plan: The plan.
    """

    plan: plan_.Plan
    due: dict[tuple[int, str, float], None] = field(default_factory=dict)  # certainly received, with the time [s]
    _received: dict[tuple[int, str], list[tuple[float, float]]] = field(default_factory=dict)
    _names: set[str] = field(default_factory=set)  # names of events with other possible subscribers

    def __post_init__(self) -> None:
        for modifier in self.plan.modifiers.values():
            for event in (*(on.event for on in modifier.on), *(sample.event for sample in modifier.samples)):
                self.give_up(event)
        for items in self.plan.coverage.values():
            self._names |= {item.event.name for item in items if isinstance(item.event, plan_.DeclaredEvent)}

    def add(self, of: int, name: str, first: float, last: float) -> None:
        """Note that a subscriber receives a derived event of an instance once between two times [s]."""
        self._received.setdefault((of, name), []).append((first, last))

    def give_up(self, specification: plan_.EventSpecification) -> None:
        """Note a subscriber for which the times are unknown."""
        self._names.update(_names(specification))

    def check(self, of: int, name: str, t: float) -> bool:
        """Whether a subscriber may receive a derived event at a time [s]."""
        received = self._received.get((of, name), ())
        return (
            any(first - _ROUNDING <= t <= last + _ROUNDING for first, last in received) or name in self._unknown()
        )

    def _unknown(self) -> set[str]:
        """Names of undecided events, including their sources."""
        found, pending = set[str](), list(self._names)
        declarations = (self.plan.scenarios, self.plan.actions, self.plan.modifiers, self.plan.objects)
        events = [event for each in declarations for declared in each.values() for event in declared.events]
        while pending:
            name = pending.pop()
            if name in found:
                continue
            found.add(name)
            for event in events:
                if event.name == name and event.specification is not None:
                    pending += _names(event.specification)
        return found


def _names(specification: plan_.EventSpecification) -> Iterator[str]:
    """Yield the name of the event that a specification refers to, if any."""
    if not isinstance(specification, plan_.OnEvent):
        return
    event = specification.event
    while isinstance(event, plan_.MemberEvent | plan_.LabelEvent):
        event = event.event
    if isinstance(event, plan_.DeclaredEvent):
        yield event.name
