"""`on` and `sample`: reactions of an instance to events (7.6.2.5.5, 7.3.6.1.2).

Their event contexts start with the execution of the instance. The instant of its end may be too late.

The event contexts of held objects start with the execution that held them first.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from seoro.lang.plan import EventSpecification, On, OnEvent, Phase, Sample, Scenario
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.frames import CANCELLED, Checker, Frame, Matched
from seoro.runtime.accept.history import LoggedEvent, Mark, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.moments import Listening, Moment, Moments
from seoro.runtime.accept.world import World
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Actor, HasFields, Struct, Value


def _first_holders(world: World, matched: Matched) -> dict[Struct | Actor, tuple[Instance, Frame] | None]:
    """Return the executions that held each struct and actor first.

    None if unknown: several may have started at once, one may not have started, or a modifier received the object
    before."""
    found: dict[Struct | Actor, tuple[Instance, Frame] | None] = {}
    for instance, frame in sorted(matched.executions, key=lambda each: each[1].start.seq):
        for holder in _held(list(dict(instance.fields).values())):
            first = found.setdefault(holder, None if frame.is_cut_at_once else (instance, frame))
            if first is not None and _are_beside(first[1], frame):
                found[holder] = None
    for node in world.history.nodes.values():
        for number in _numbers(node.arguments):
            given = world.objects.get(number)
            first = found.get(given) if given is not None else None
            if given is not None and first is not None and node.start.seq < first[1].start.seq:
                found[given] = None
    return found


def _are_beside(first: Frame, second: Frame) -> bool:
    """Whether either execution may have started first."""
    if first.start.t != second.start.t or first.end.seq < second.start.seq:
        return False
    node: Node | None = second.node
    while node is not None and node is not first.node:
        node = node.parent
    return node is None


def _held(values: list[Value]) -> Iterator[Struct | Actor]:
    seen: set[int] = set()
    while values:
        value = values.pop()
        if isinstance(value, tuple):
            values += value
        elif isinstance(value, Struct | Actor) and id(value) not in seen:
            seen.add(id(value))
            yield value
            values += dict(value.fields).values()


def _numbers(recorded: Any) -> Iterator[int]:
    """Yield the numbers of instances in an encoded value."""
    if isinstance(recorded, dict):
        if isinstance(recorded.get("object"), int):
            yield recorded["object"]
        for value in recorded.values():
            yield from _numbers(value)
    elif isinstance(recorded, list):
        for value in recorded:
            yield from _numbers(value)


@dataclass(eq=False)
class ReactionChecker(Checker):
    """Check of reactions.

    Args:
        moments: Finds when specifications are met.
    """

    moments: Moments

    def check(self, matched: Matched) -> None:
        """Check all reactions."""
        reactions = {(instance.number, id(on)): nodes for instance, on, nodes in matched.reactions}
        for instance, frame in matched.executions:
            for directive in instance.declaration.on:
                self._on(directive, instance, frame, reactions.get((instance.number, id(directive)), ()))
            for sample in instance.declaration.samples:
                self._sample(sample, instance, instance, frame)
        for holder, within in _first_holders(self.world, matched).items():
            for sample in self.world.samples_of(holder):
                if within is None:
                    reason = f"the trace does not show which scenario held a `{holder.types[0]}` first"
                    self.findings.skip(Rule.SAMPLE, reason, sample.span)
                    self.moments.received.give_up(sample.event)
                else:
                    self._sample(sample, holder, *within)

    def _found(
        self,
        event: EventSpecification,
        environment: Environment,
        instance: Instance,
        frame: Frame,
        own: frozenset[int] = frozenset(),
    ) -> list[Moment]:
        """Return the moments of an event for an instance; emissions of its own reaction may not count."""
        has_end = isinstance(instance.declaration, Scenario) or not frame.held
        receives_until = self._end(instance, frame) if has_end else frame.start.t
        listening = Listening(frame.start, frame.end.t, environment, frame.node, receives_until)
        found = self.moments.of(event, listening)
        return [each if own.isdisjoint(each.records) else replace(each, sure=False) for each in found]

    def _on(self, directive: On, instance: Instance, frame: Frame, nodes: tuple[Node, ...]) -> None:
        emitted = (self.moments.pasts.emitted.get(node.number) for node in nodes)
        own = frozenset(occurrence.mark.seq for occurrence in emitted if occurrence is not None)
        with self.findings.undecided(Rule.ON, directive.span):
            found = self._found(directive.event, instance.environment, instance, frame, own)
            for number, member in enumerate(directive.members):
                plans, span = self.moments.pasts.matched.plans, member.span if number else directive.span
                marks = [node.start for node in nodes if plans.get(node.number) is member]
                self._compare(found, marks, Rule.ON, span, self._end(instance, frame))

    def _end(self, instance: Instance, frame: Frame) -> float:
        """Return the end of an instance [s]; a held behavior lasts longer than its invocation."""
        ends = [
            occurrence.mark.t
            for phase in (Phase.END, Phase.FAIL)
            for occurrence in self.history.events.get((instance.number, phase.value), ())
        ]
        ends += [child.end.t for child in frame.children if child.status == CANCELLED]  # its `do`
        return min([*ends, frame.end.t])

    def _compare(self, found: list[Moment], reactions: list[Mark], rule: Rule, span: Span, end: float) -> None:
        """Compare the times of reactions with those of the event, before the end [s] of the instance."""
        times, records = Counter(mark.t for mark in reactions), {mark.t: mark.seq for mark in reactions}
        for t, count in times.items():
            if count > sum(moment.first <= t <= moment.last for moment in found):
                message = f"it reacts {_times(count)} at {t:g} s, but its event has not occurred as often"
                self.findings.violate(rule, message, span, records[t])
        due = Counter(moment.first for moment in found if moment.sure and moment.first == moment.last)
        for t, count in due.items():
            if times[t] < count and t < end:
                seen = [seq for moment in found if moment.first == t for seq in moment.records]
                message = f"it reacts {_times(times[t])} at {t:g} s, but its event occurs {_times(count)}"
                self.findings.violate(rule, message, span, *seen)

    # -------------------------------------------------------- sampled variables

    def _sample(self, sample: Sample, holder: HasFields, instance: Instance, frame: Frame) -> None:
        """Check that a sampled variable changes whenever its event occurs."""
        environment = self.world.scope_of(holder, instance.environment)
        changes = [
            change
            for change in self.history.changes.get((self.world.number(holder) or 0, sample.field), ())
            if change.recorded.get("by") == frame.node.number
            and frame.start.seq < change.mark.seq
            and change.mark.t <= frame.end.t
        ]
        with self.findings.undecided(Rule.SAMPLE, sample.span):
            found = self._found(sample.event, environment, instance, frame)
            marks = [change.mark for change in changes]
            self._compare(found, marks, Rule.SAMPLE, sample.span, self._end(instance, frame))
            for change in changes:
                self._check_value(sample, self._scopes(sample, environment, found, change.mark.t), change)

    def _scopes(
        self, sample: Sample, environment: Environment, found: list[Moment], t: float
    ) -> list[Environment]:
        """Return the environments of a sample: one for each occurrence that `as` may be bound to."""
        if not isinstance(sample.event, OnEvent) or sample.event.name is None:
            return [environment]
        meant = [moment for moment in found if moment.first <= t <= moment.last]
        return [self.moments.named(sample.event.name, moment, environment) for moment in meant]

    def _check_value(self, sample: Sample, scopes: list[Environment], change: LoggedEvent) -> None:
        """Check that the value is one that the expression had in a delta cycle of that instant."""
        if not scopes:
            return  # a reaction without event: reported elsewhere
        records, seq, t = self.history.records, change.mark.seq, change.mark.t
        places = [seq]
        while seq > 0 and records[seq - 1]["t"] == t and len(places) < 50:
            seq -= 1
            if records[seq]["kind"] in ("variable", "instance"):
                places.append(seq)
        with self.findings.undecided(Rule.SAMPLE, sample.span):
            recorded = self.world.decode(change.recorded["exact"])
            values = [self.world.value(sample.value, scope, place) for scope in scopes for place in [*places, seq]]
            if all(type(value) is type(recorded) and value != recorded for value in values):
                expected = f"{values[0]} from `{sample.value.span.text}`"
                message = f"`{sample.field}` takes the value {recorded}; expected {expected}"
                self.findings.violate(Rule.SAMPLE, message, sample.span, change.mark.seq)


def _times(count: int) -> str:
    return {0: "not", 1: "once"}.get(count, f"{count} times")
