"""Causal pasts in an instant (7.6.2.5): occurrences that a task does not receive (again).

An occurrence belongs to an instant. A task does not receive occurrences that it emitted or received itself, nor
those of the tasks that started it or that it joined. A trace does not identify the occurrence that ended a `wait`;
if several may have, they are *perhaps* in the past.
"""

from __future__ import annotations

import math
from bisect import bisect, bisect_left
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

from seoro.lang.plan import Emit, EventSpecification, InvokeAction, InvokeScenario
from seoro.runtime.accept.channels import Channels
from seoro.runtime.accept.findings import Undecided
from seoro.runtime.accept.frames import SUCCEEDED, Frame, Matched, is_ending
from seoro.runtime.accept.history import LoggedEvent, Mark, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Value

_PHASES: Final = ("start", "end", "fail")


@dataclass
class Past:
    """Records of events in the past of a subscriber.

    Args:
        surely: Certain ones.
        perhaps: Possible ones.
    """

    surely: set[int] = field(default_factory=set)
    perhaps: set[int] = field(default_factory=set)


@dataclass(eq=False)
class Pasts:
    """Finds causal pasts.

    Args:
        matched: Matched behaviors.
        channels: Resolves event references.
    """

    matched: Matched
    channels: Channels
    emitted: dict[int, LoggedEvent] = field(default_factory=dict, init=False)  # by numbers of behaviors

    def __post_init__(self) -> None:
        for plan, node, instance in self.matched.all_emits:
            occurrence = None if is_ending(plan) else self._occurrence(plan, node, instance)
            if occurrence is not None:
                self.emitted[node.number] = occurrence
        self._reactions = {node.number for _, _, nodes in self.matched.reactions for node in nodes}
        self._waits = {node.number: (plan, instance) for plan, node, instance in self.matched.waits}
        self._labels = {node.number: (label, instance) for label, node, instance in self.matched.labels}
        self._untils: dict[int, list[tuple[EventSpecification, Frame, Environment]]] = {}
        for layer, frame, environment in self.matched.untils:
            for directive in layer.directives:
                listening = (directive.event, frame, environment)
                self._untils.setdefault(frame.node.number, []).append(listening)

    def _occurrence(self, plan: Emit, node: Node, instance: Instance) -> LoggedEvent | None:
        """Return the occurrence of an `emit`; an equal emission before in that instant may be the same."""
        world, name = self.channels.world, plan.event.name
        event = self.channels.event_of(instance, name)
        given = dict(plan.arguments) if event is None else event.all_arguments(plan.arguments)
        arguments: dict[str, Value] | None = None  # if the trace lacks them
        with suppress(Undecided):
            seq = node.start.seq
            arguments = {each: world.value(value, instance.environment, seq) for each, value in given.items()}
        fitting = [
            each
            for each in self.channels.at(instance.number, name, node.start.t)
            if not each.is_derived
            and each.mark.seq < node.end.seq
            and (arguments is None or _same(world.arguments.get(each.mark.seq, {}), arguments))
        ]
        return fitting[-1] if fitting else None

    def before(self, node: Node, mark: Mark) -> Past:
        """Return the past of a task at a place within a behavior."""
        past = Past()
        current: Node | None = node
        while current is not None:
            self._add_beginning(current, mark, past)
            self._add_untils(current, mark, past)  # earlier attempts
            for earlier, joined in self._ended_before(current, mark):
                self._add_all(earlier, joined, past)
            mark = Mark(current.start.seq, mark.t)
            current = current.parent
        past.perhaps -= past.surely
        return past

    def _ended_before(self, node: Node, mark: Mark) -> Iterator[tuple[Node, Mark]]:
        """Yield the parts of a behavior that ended in an instant before a record, with their place.

        Parallel members are joined by the end of all, or by the next attempt of a modifier."""
        are_beside = node.owner.type in ("parallel", "one_of")
        if are_beside:
            begun = bisect(node.attempts, mark.seq, key=lambda attempt: attempt.start.seq)
            if begun == 0:
                return
            mark = Mark(node.attempts[begun - 1].start.seq, mark.t)
        started = bisect_left(node.children, mark.seq, key=lambda child: child.start.seq)
        for index in reversed(range(started)):
            child = node.children[index]
            if child.number in self._reactions:
                continue
            if child.end.t < mark.t and not are_beside:
                return
            if child.end.t == mark.t and child.end.seq < mark.seq:
                yield child, mark

    def _add_beginning(self, node: Node, mark: Mark, past: Past) -> None:
        """Add the start events of a running behavior: those of its label and of its invocation."""
        if node.start.t != mark.t:
            return
        if node.number in self._labels:
            label, around = self._labels[node.number]
            self._add_events(around.number, (f"{label}.start",), mark.t, past)
        if node.type in ("scenario", "action"):
            for number in node.instances:
                self._add_events(number, ("start",), mark.t, past, mark.seq)

    def _add_all(self, first: Node, joined: Mark, past: Past) -> None:
        """Add the emitted and received occurrences of an ended behavior, in an instant before a record."""
        pending, t = [first], joined.t
        while pending:
            node = pending.pop()
            if node.number in self._reactions or node.end.t < t:
                continue
            pending += node.children
            if node.number in self.emitted:
                past.surely.add(self.emitted[node.number].mark.seq)
            if node.number in self._labels:
                label, around = self._labels[node.number]
                self._add_events(around.number, [f"{label}.{phase}" for phase in _PHASES], t, past, joined.seq)
            if isinstance(self.matched.plans.get(node.number), InvokeScenario | InvokeAction):
                for number in node.instances:
                    self._add_events(number, _PHASES, t, past, joined.seq)
            if node.number in self._waits and node.end.t == t and node.status == SUCCEEDED:
                plan, instance = self._waits[node.number]
                self._consume(plan.event, instance.environment, node.start, node.end, past)
            self._add_untils(node, Mark(node.end.seq + 1, t), past)

    def _add_events(
        self, number: int, names: Iterable[str], t: float, past: Past, before: float = math.inf
    ) -> None:
        """Add the occurrences of events of an instance, in an instant before a record."""
        found = (each.mark.seq for name in names for each in self.channels.at(number, name, t))
        past.surely.update(seq for seq in found if seq < before)

    def _add_untils(self, node: Node, mark: Mark, past: Past) -> None:
        """Add the events that met an `until` of a behavior, or of attempts, in an instant before a record."""
        for event, frame, environment in self._untils.get(node.number, ()):
            if frame.end.t == mark.t and frame.end.seq < mark.seq:
                self._consume(event, environment, frame.start, frame.end, past)

    def _consume(
        self, specification: EventSpecification, environment: Environment, start: Mark, end: Mark, past: Past
    ) -> None:
        """Add the occurrences that met a specification between two places, at the second one."""
        try:
            sources, is_all = self.channels.sources(specification, environment, start, end.t)
        except Undecided:
            return
        found = {seq for seq in sources if seq < end.seq}
        (past.surely if is_all and len(found) == 1 else past.perhaps).update(found)


def _same(recorded: dict[str, Value], evaluated: dict[str, Value]) -> bool:
    """Whether arguments are equal; values missing in the trace match any."""
    return recorded.keys() == evaluated.keys() and all(
        type(recorded[name]) is not type(value) or recorded[name] == value for name, value in evaluated.items()
    )
