"""`on` and `sample`: what an instance does whenever an event occurs (7.6.2.5.5, 7.3.6.1.2).

Their event contexts start with the execution of the instance. The instant in which that ends may be too late.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import partial

from seoro.lang.plan import EventSpecification, On, OnEvent, Phase, Sample, Scenario
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Findings, Rule, Undecided
from seoro.runtime.accept.frames import CANCELLED, Frame, Matched
from seoro.runtime.accept.held import Held
from seoro.runtime.accept.history import Happening, History, Node
from seoro.runtime.accept.moments import Listening, Moment, Moments
from seoro.runtime.accept.pasts import Pasts
from seoro.runtime.accept.world import EventObject, Instance, World
from seoro.runtime.environment import Environment
from seoro.runtime.values import HasFields


@dataclass(eq=False)
class Reacting:
    """Checks reactions.

    Args:
        history: The trace.
        world: Its values.
        moments: Finds when specifications are met.
        pasts: Finds what is not seen.
        findings: Gets what is wrong.
    """

    history: History
    world: World
    moments: Moments
    pasts: Pasts
    findings: Findings

    def check(self, matched: Matched) -> None:
        """Check all of them."""
        reactions = {(instance.number, id(on)): nodes for instance, on, nodes in matched.reactions}
        for instance, frame in matched.executions:
            for directive in instance.declaration.on:
                self._on(directive, instance, frame, reactions.get((instance.number, id(directive)), ()))
            for sample in instance.declaration.samples:
                self._sample(sample, instance, instance, frame)
        held = Held(self.world, self.history, matched)
        for holder, within in held.first_by().items():
            for sample in self.world.samples_of(holder):
                if within is None:
                    reason = f"which scenario held a `{holder.types[0]}` first is not told"
                    self.findings.skip(Rule.SAMPLE, reason, sample.span)
                    self.moments.hearing.give_up(sample.event)
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
        """When an event is met for an instance; what its own reaction emitted it may not have seen."""
        past = partial(self.pasts.before, frame.node, frame.start)
        has_end = isinstance(instance.declaration, Scenario) or not frame.held
        heard_until = self._end(instance, frame) if has_end else frame.start.t
        listening = Listening(frame.start, frame.end.t, environment, past, heard_until)
        found = self.moments.of(event, listening)
        return [
            replace(each, sure=False) if each.happening is not None and each.happening.mark.seq in own else each
            for each in found
        ]

    def _on(self, directive: On, instance: Instance, frame: Frame, nodes: tuple[Node, ...]) -> None:
        emitted = (self.pasts.emitted.get(node.number) for node in nodes)
        own = frozenset(happening.mark.seq for happening in emitted if happening is not None)
        try:
            found = self._found(directive.event, instance.environment, instance, frame, own)
        except Undecided as why:
            self.findings.skip(Rule.ON, why, directive.span)
            return
        for number, member in enumerate(directive.members):
            mine = [node for node in nodes if self.pasts.matched.plans.get(node.number) is member]
            times = Counter(node.start.t for node in mine)
            records = {node.start.t: node.start.seq for node in mine}
            span = member.span if number else directive.span
            self._compare(found, times, records, Rule.ON, span, self._end(instance, frame))

    def _end(self, instance: Instance, frame: Frame) -> float:
        """When an instance ended [s]; a behavior that holds until something lasts longer than what it invoked."""
        ends = [
            happening.mark.t
            for phase in (Phase.END, Phase.FAIL)
            for happening in self.history.events.get((instance.number, phase.value), ())
        ]
        ends += [child.end.t for child in frame.children if child.status == CANCELLED]  # its `do`
        return min([*ends, frame.end.t])

    def _compare(
        self,
        found: list[Moment],
        times: Counter[float],
        records: dict[float, int],
        rule: Rule,
        span: Span,
        end: float,
    ) -> None:
        """Compare when something was done with when it should have been, before the end [s] of the instance."""
        for t, count in times.items():
            if count > sum(moment.first <= t <= moment.last for moment in found):
                message = f"it reacts {_times(count)} at {t:g} s, and its event has not occurred so often"
                self.findings.violate(rule, message, span, records[t])
        due = Counter(moment.first for moment in found if moment.sure and moment.first == moment.last)
        for t, count in due.items():
            if times[t] < count and t < end:
                seen = [m.happening.mark.seq for m in found if m.happening is not None and m.first == t]
                message = f"it reacts {_times(times[t])} at {t:g} s, and its event occurs {_times(count)}"
                self.findings.violate(rule, message, span, *seen)

    # -------------------------------------------------------- sampled variables

    def _sample(self, sample: Sample, holder: HasFields, instance: Instance, frame: Frame) -> None:
        """A sampled variable of an instance, or of what that holds, takes its value whenever its event occurs."""
        environment = self.world.scope_of(holder, instance.environment)
        changes = [
            change
            for change in self.history.changes.get((self.world.number(holder) or 0, sample.field), ())
            if change.told.get("by") == frame.node.number and frame.start.seq < change.mark.seq
        ]
        changes = [change for change in changes if change.mark.t <= frame.end.t]
        try:
            found = self._found(sample.event, environment, instance, frame)
        except Undecided as why:
            self.findings.skip(Rule.SAMPLE, why, sample.span)
            return
        times = Counter(change.mark.t for change in changes)
        records = {change.mark.t: change.mark.seq for change in changes}
        self._compare(found, times, records, Rule.SAMPLE, sample.span, self._end(instance, frame))
        for change in changes:
            self._check_value(sample, self._scopes(sample, environment, found, change.mark.t), change)

    def _scopes(
        self, sample: Sample, environment: Environment, found: list[Moment], t: float
    ) -> list[Environment]:
        """The scopes in which a value may have been sampled: one for each occurrence that `as` may stand for."""
        if not isinstance(sample.event, OnEvent) or sample.event.name is None:
            return [environment]
        scopes: list[Environment] = []
        for moment in found:
            if moment.first <= t <= moment.last:
                happening = moment.happening
                arguments = self.world.arguments.get(happening.mark.seq, {}) if happening is not None else {}
                bindings = {**environment.bindings, sample.event.name: EventObject(arguments)}
                scopes.append(replace(environment, bindings=bindings))
        return scopes

    def _check_value(self, sample: Sample, scopes: list[Environment], change: Happening) -> None:
        """The value is what the expression had in one of the rounds of that instant."""
        if not scopes:
            return  # it reacted to nothing, which is reported
        records, seq, t = self.history.records, change.mark.seq, change.mark.t
        places = [seq]
        while seq > 0 and records[seq - 1]["t"] == t and len(places) < 50:
            seq -= 1
            if records[seq]["kind"] in ("variable", "instance"):
                places.append(seq)
        try:
            told = self.world.decode(change.told["exact"])
            values = [self.world.value(sample.value, scope, place) for scope in scopes for place in [*places, seq]]
        except Undecided as why:
            self.findings.skip(Rule.SAMPLE, why, sample.span)
            return
        if all(type(value) is type(told) and value != told for value in values):
            message = f"`{sample.field}` takes the value {told}, and `{sample.value.span.text}` is {values[0]}"
            self.findings.violate(Rule.SAMPLE, message, sample.span, change.mark.seq)


def _times(count: int) -> str:
    return {0: "not", 1: "once"}.get(count, f"{count} times")
