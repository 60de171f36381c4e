"""Subscribers of derived events (7.3.10.4): without a subscriber that is met, a derived event does not occur.

Subscribers are tracked where a rule computes when a specification is met. Events with other possible subscribers
are not decided.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from seoro.lang import plan as plan_

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
        heard = self._received.get((of, name), ())
        return any(first - _ROUNDING <= t <= last + _ROUNDING for first, last in heard) or name in self._unknown()

    def _unknown(self) -> set[str]:
        """Names of undecided events, including their sources."""
        found, pending = set[str](), list(self._names)
        while pending:
            name = pending.pop()
            if name in found:
                continue
            found.add(name)
            for event in self._declared():
                if event.name == name and event.specification is not None:
                    pending += _names(event.specification)
        return found

    def _declared(self) -> Iterator[plan_.Event]:
        plan = self.plan
        for declared in (plan.scenarios, plan.actions, plan.modifiers, plan.objects):
            for each in declared.values():
                yield from each.events


def _names(specification: plan_.EventSpecification) -> Iterator[str]:
    """Yield the name of the event that a specification refers to, if any."""
    if not isinstance(specification, plan_.OnEvent):
        return
    event = specification.event
    while isinstance(event, plan_.MemberEvent | plan_.LabelEvent):
        event = event.event
    if isinstance(event, plan_.DeclaredEvent):
        yield event.name
