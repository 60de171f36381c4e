"""`emit`, and that events occur when something makes them occur, and only then (7.6.2.5.1, 7.6.2.5.2)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from seoro.lang.plan import DeclaredEvent, Emit, Fall, Holds, OnEvent, Phase, PhaseEvent, Rise, Scenario
from seoro.lang.source import Span
from seoro.runtime.accept.channels import Channels
from seoro.runtime.accept.findings import Findings, Rule, Undecided
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Frame, Matched, is_ending
from seoro.runtime.accept.history import Happening, History, Node
from seoro.runtime.accept.moments import Moments
from seoro.runtime.accept.world import Instance, World
from seoro.runtime.environment import Environment
from seoro.runtime.values import Actor, Struct, Value


@dataclass(eq=False)
class Emitting:
    """Checks events.

    Args:
        history: The trace.
        world: Its values.
        channels: Finds events.
        moments: Finds when conditions hold.
        findings: Gets what is wrong.
    """

    history: History
    world: World
    channels: Channels
    moments: Moments
    findings: Findings

    def emitted(self, matched: Matched) -> dict[int, Happening]:
        """The occurrences that behaviors emitted, by the numbers of these."""
        found: dict[int, Happening] = {}
        for plan, node, instance in _emits(matched):
            happening = self._occurrence(plan, node, instance)
            if happening is not None:
                found[node.number] = happening
        return found

    def _occurrence(self, plan: Emit, node: Node, instance: Instance) -> Happening | None:
        """What an `emit` emitted; what was emitted before in that instant may be the same."""
        if is_ending(plan):
            return None
        candidates = [
            happening
            for happening in self.channels.at(instance.number, _name(plan), node.start.t)
            if not happening.is_derived and happening.mark.seq < node.end.seq
        ]
        arguments = self._arguments(plan, node, instance)
        fitting = [
            happening
            for happening in candidates
            if arguments is None or _same(self.world.arguments.get(happening.mark.seq, {}), arguments)
        ]
        return fitting[-1] if fitting else None

    def _arguments(self, plan: Emit, node: Node, instance: Instance) -> dict[str, Value] | None:
        """The arguments of an `emit`; None if the trace does not tell them."""
        try:
            environment = instance.environment
            given = dict(plan.arguments)
            for event in instance.declaration.events:
                if event.name == _name(plan):
                    given = event.all_arguments(plan.arguments)
            return {name: self.world.value(value, environment, node.start.seq) for name, value in given.items()}
        except Undecided:
            return None

    # -------------------------------------------------------- rules

    def check(self, matched: Matched) -> None:
        """Check all of it."""
        emitted = self.emitted(matched)
        for plan, node, instance in _emits(matched):
            if is_ending(plan):
                self._ending(plan, node, instance, matched)
            elif node.number not in emitted and node.status == SUCCEEDED:
                message = f"`{_name(plan)}` does not occur when it is emitted, or with other arguments"
                self.findings.violate(Rule.EMIT, message, plan.span, *node.records)
        explained = {happening.mark.seq for happening in emitted.values()}
        explained |= set(self._of_labels(matched))
        explained |= set(self._of_instances(matched))
        for (number, name), happenings in self.history.events.items():
            self._declared(number, name, happenings, explained)
        self._all_heard()

    def _ending(self, plan: Emit, node: Node, instance: Instance, matched: Matched) -> None:
        """`emit end` and `emit fail` end the scenario in which they stand."""
        frames = (
            frame
            for each, frame in matched.executions
            if each is instance and frame.start.seq < node.start.seq < frame.end.seq
        )
        frame = next(frames, None)
        if frame is None or frame.held:
            return
        if not self.history.lasts(node.end.t, frame.end.t):
            message = f"its scenario goes on until {frame.end.t:g} s"
            self.findings.violate(Rule.EMIT, message, plan.span, *node.records, frame.end.seq)
            return
        event = plan.event
        assert isinstance(event, PhaseEvent), "it ends its scenario"
        status = SUCCEEDED if event.phase is Phase.END else FAILED
        others = [
            other
            for each, other, within in _emits(matched)
            if within is instance and is_ending(each) and other.start.t == node.start.t
        ]
        body_ended = any(child.status == FAILED and child.end.t == node.end.t for child in frame.children)
        if frame.status not in (status, CANCELLED) and len(others) == 1 and not body_ended:
            message = f"its scenario {frame.status}"
            self.findings.violate(Rule.EMIT, message, plan.span, *node.records, frame.end.seq)

    def _of_labels(self, matched: Matched) -> Iterator[int]:
        """The events of labelled members, which start and end with them."""
        for label, node, around in matched.labels:
            yield from self._due(around, f"{label}.start", node.start.t, node, must=True)
            phase = "fail" if node.status == FAILED else "end"
            yield from self._due(around, f"{label}.{phase}", node.end.t, node, must=node.status != CANCELLED)

    def _due(self, holder: Instance, name: str, t: float, node: Node, *, must: bool) -> Iterator[int]:
        """The records of an event that is due."""
        found = [each for each in self.channels.at(holder.number, name, t) if not each.is_derived]
        if must and not found:
            message = f"`{name}` does not occur at {t:g} s"
            plan = holder.declaration
            self.findings.violate(Rule.EVENT, message, plan.span, *node.records)
        yield from (each.mark.seq for each in found)

    def _of_instances(self, matched: Matched) -> Iterator[int]:
        """The events of instances, which start and end with them; those of actions if anybody wants them."""
        for instance, frame in matched.executions:
            is_scenario = isinstance(instance.declaration, Scenario)
            number = instance.number
            is_cut = frame.end.t == frame.start.t and frame.status in frame.cuts
            must = is_scenario and not is_cut
            started = list(self._due(instance, "start", frame.start.t, frame.node, must=must))
            yield from started
            if frame.held or SUCCEEDED in frame.cuts:
                found = list(self._any_end(number, frame))
                is_due = is_scenario and frame.status != CANCELLED and not frame.is_secondary
                is_due = is_due and any(frame.start.seq < seq < frame.end.seq for seq in started)
                if is_due and not found and not matched.overrides:
                    message = f"it {frame.status}, and neither `end` nor `fail` occurs"
                    self.findings.violate(Rule.EVENT, message, instance.declaration.span, *frame.records)
                yield from found
                continue
            phase = "fail" if frame.status == FAILED else "end"
            must = is_scenario and frame.status != CANCELLED
            yield from self._due(instance, phase, frame.end.t, frame.node, must=must)
            if frame.status == CANCELLED:
                yield from self._any_end(number, frame)

    def _any_end(self, number: int, frame: Frame) -> Iterator[int]:
        """Its end at any time, if something may hold it longer."""
        for phase in ("end", "fail"):
            found = self.channels.between(number, phase, frame.start.t, frame.end.t)
            yield from (each.mark.seq for each in found[:1])

    def _declared(self, number: int, name: str, happenings: list[Happening], explained: set[int]) -> None:
        """Each occurrence has an emission, or what the event is declared to be has occurred."""
        holder = self.world.holder(number)
        if holder is None:
            return
        declared = next((event for event in self.channels.events_of(holder) if event.name == name), None)
        around = holder.declaration.span if isinstance(holder, Instance) else None
        span = declared.span if declared is not None else around
        seen: Counter[tuple[float, bool, str]] = Counter()
        for happening in happenings:
            seq, t = happening.mark
            key = t, happening.is_derived, repr(sorted(happening.told["arguments"].items()))
            seen[key] += 1
            if seen[key] > 1:
                self.findings.violate(Rule.EVENT, f"`{name}` occurs twice at {t:g} s", span, seq)
            if happening.is_derived:
                self._derived(holder, happening)
                self._heard(happening, span)
            elif isinstance(holder, Instance):
                if seq not in explained:
                    message = f"`{name}` occurs at {t:g} s, and nothing emits it"
                    self.findings.violate(Rule.EVENT, message, span, seq)
                if declared is not None:
                    self._fits({parameter for parameter, _ in declared.parameters}, happening, name)

    def _heard(self, happening: Happening, span: Span | None) -> None:
        """Someone listens to a derived event, and hears it then."""
        if not self.moments.hearing.check(happening.of, happening.name, happening.mark.t):
            message = f"`{happening.name}` occurs at {happening.mark.t:g} s, and nobody who listens hears it then"
            self.findings.violate(Rule.EVENT, message, span, happening.mark.seq)

    def _all_heard(self) -> None:
        """Where someone hears a derived event, it occurs."""
        for number, name, t in self.moments.hearing.due:
            if not any(happening.is_derived for happening in self.channels.at(number, name, t)):
                message = f"`{name}` does not occur at {t:g} s, where someone who listens hears it"
                self.findings.violate(Rule.EVENT, message, None)

    def _fits(self, parameters: set[str], happening: Happening, name: str) -> None:
        """Its arguments are those that it is declared with."""
        told = happening.told["arguments"]
        if set(told) != parameters:
            message = f"`{name}` has the arguments {sorted(told)}, and is declared with {sorted(parameters)}"
            self.findings.violate(Rule.EVENT, message, None, happening.mark.seq)

    def _derived(self, holder: Instance | Struct | Actor, happening: Happening) -> None:
        """What an event is declared to be has occurred; when the contexts of conditions began is not known."""
        name = happening.name
        declared = next((event for event in self.channels.events_of(holder) if event.name == name), None)
        specification = declared.specification if declared is not None else None
        if declared is None or specification is None:
            message = f"`{name}` occurs, and neither is emitted nor declared to be something else"
            span = holder.declaration.span if isinstance(holder, Instance) else None
            self.findings.violate(Rule.EVENT, message, span, happening.mark.seq)
            return
        environment = holder.environment if isinstance(holder, Instance) else self._inside(holder)
        if isinstance(specification, Holds | Rise | Fall):
            self._condition(specification, environment, happening, declared.span)
        if not isinstance(specification, OnEvent) or not isinstance(
            specification.event, DeclaredEvent | PhaseEvent
        ):
            return
        try:
            channels = list(self.channels.resolve(specification.event, environment, happening.mark))
        except Undecided as why:
            self.findings.skip(Rule.EVENT, why, declared.span)
            return
        if not any(self.channels.at(channel.of, channel.name, happening.mark.t) for channel in channels):
            message = f"`{name}` occurs, and what it is declared to be does not"
            self.findings.violate(Rule.EVENT, message, declared.span, happening.mark.seq)

    def _inside(self, holder: Struct | Actor) -> Environment:
        """What names stand for in a struct or an actor."""
        entry = self.world.instances[self.history.root.instances[0]]
        return Environment(holder, {}, scenario=entry)

    def _condition(
        self, condition: Holds | Rise | Fall, environment: Environment, happening: Happening, span: Span
    ) -> None:
        """A condition that an event is declared to be has the value then that makes it occur."""
        try:
            values = self.moments.values_at(condition.condition, environment, happening.mark.t)
        except Undecided as why:
            self.findings.skip(Rule.EVENT, why, span)
            return
        if (not isinstance(condition, Fall)) not in values:
            message = f"`{happening.name}` occurs at {happening.mark.t:g} s, and its condition has another value"
            self.findings.violate(Rule.EVENT, message, span, happening.mark.seq)


def _emits(matched: Matched) -> Iterator[tuple[Emit, Node, Instance]]:
    """All that was emitted, by members and by reactions."""
    yield from matched.emits
    for instance, _, nodes in matched.reactions:
        for node in nodes:
            plan = matched.plans.get(node.number)
            if isinstance(plan, Emit):
                yield plan, node, instance


def _name(plan: Emit) -> str:
    event = plan.event
    if isinstance(event, DeclaredEvent):
        return event.name
    return f"{event.label}.{event.phase.value}" if event.label is not None else event.phase.value


def _same(told: dict[str, Value], evaluated: dict[str, Value]) -> bool:
    """Whether arguments are the same; a value that the trace does not tell of may be any."""
    return told.keys() == evaluated.keys() and all(
        type(told[name]) is not type(value) or told[name] == value for name, value in evaluated.items()
    )
