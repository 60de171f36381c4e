"""`emit` and events: an event occurs if and only if it has a cause (7.6.2.5.1, 7.6.2.5.2)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from seoro.lang.plan import DeclaredEvent, Emit, Event, Fall, Holds, OnEvent, Phase, PhaseEvent, Rise, Scenario
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Checker, Frame, Matched, is_ending
from seoro.runtime.accept.history import LoggedEvent, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.moments import Moments
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Actor, Struct

_APPLICATION = "application"  # origin of external emissions
_ATTEMPT = re.compile(r"#\d+")  # attempt of a modifier, in the name of an event


@dataclass(eq=False)
class EventChecker(Checker):
    """Check of events.

    Args:
        moments: Finds when conditions hold.
    """

    moments: Moments

    def __post_init__(self) -> None:
        self.channels = self.moments.channels

    def check(self, matched: Matched) -> None:
        """Check all emissions and occurrences."""
        emitted = self.moments.pasts.emitted
        for plan, node, instance in matched.all_emits:
            if is_ending(plan):
                self._ending(plan, node, instance, matched)
            elif node.number not in emitted and node.status == SUCCEEDED:
                message = f"`{plan.event.name}` does not occur when it is emitted, or has other arguments"
                self.findings.violate(Rule.EMIT, message, plan.span, *node.records)
        explained = {occurrence.mark.seq for occurrence in emitted.values()}
        explained |= set(self._of_labels(matched))
        explained |= set(self._of_instances(matched))
        for (number, name), occurrences in self.history.events.items():
            self._declared(number, name, occurrences, explained)
        self._all_received()

    def _ending(self, plan: Emit, node: Node, instance: Instance, matched: Matched) -> None:
        """Check that `emit end` and `emit fail` end their scenario."""
        frames = (
            frame
            for each, frame in matched.executions
            if each is instance and frame.start.seq < node.start.seq < frame.end.seq
        )
        frame = next(frames, None)
        if frame is None or frame.held:
            return
        if not self.history.lasts(node.end.t, frame.end.t):
            message = f"its scenario continues until {frame.end.t:g} s"
            self.findings.violate(Rule.EMIT, message, plan.span, *node.records, frame.end.seq)
            return
        event = plan.event
        assert isinstance(event, PhaseEvent), "`end` or `fail`"
        status = SUCCEEDED if event.phase is Phase.END else FAILED
        others = [
            other
            for each, other, within in matched.all_emits
            if within is instance and is_ending(each) and other.start.t == node.start.t
        ]
        body_ended = any(child.status == FAILED and child.end.t == node.end.t for child in frame.children)
        if frame.status not in (status, CANCELLED) and len(others) == 1 and not body_ended:
            message = f"its scenario {frame.status}"
            self.findings.violate(Rule.EMIT, message, plan.span, *node.records, frame.end.seq)

    def _of_labels(self, matched: Matched) -> Iterator[int]:
        """Check the events of labelled members; yield their records."""
        for label, node, around in matched.labels:
            yield from self._due(around, f"{label}.start", node.start.t, node, must=True)
            phase = "fail" if node.status == FAILED else "end"
            yield from self._due(around, f"{label}.{phase}", node.end.t, node, must=node.status != CANCELLED)

    def _due(self, holder: Instance, name: str, t: float, node: Node, *, must: bool) -> Iterator[int]:
        """Yield the records of a due event; report it if missing."""
        found = [each for each in self.channels.at(holder.number, name, t) if not each.is_derived]
        if must and not found:
            message = f"`{name}` does not occur at {t:g} s"
            plan = holder.declaration
            self.findings.violate(Rule.EVENT, message, plan.span, *node.records)
        yield from (each.mark.seq for each in found)

    def _of_instances(self, matched: Matched) -> Iterator[int]:
        """Check the events of instances, those of actions if they may be used; yield their records."""
        for instance, frame in matched.executions:
            is_scenario = isinstance(instance.declaration, Scenario)
            number = instance.number
            must = is_scenario and not frame.is_cut_at_once
            started = list(self._due(instance, "start", frame.start.t, frame.node, must=must))
            yield from started
            if frame.held or SUCCEEDED in frame.cuts:
                found = list(self._any_end(number, frame))
                is_due = is_scenario and frame.status != CANCELLED and not frame.is_secondary
                is_due = is_due and any(frame.start.seq < seq < frame.end.seq for seq in started)
                if is_due and not found and not matched.overrides:
                    message = f"it {frame.status}, but neither `end` nor `fail` occurs"
                    self.findings.violate(Rule.EVENT, message, instance.declaration.span, *frame.records)
                yield from found
                continue
            phase = "fail" if frame.status == FAILED else "end"
            must = is_scenario and frame.status != CANCELLED
            yield from self._due(instance, phase, frame.end.t, frame.node, must=must)
            if frame.status == CANCELLED:
                yield from self._any_end(number, frame)

    def _any_end(self, number: int, frame: Frame) -> Iterator[int]:
        """Yield the end events of an instance at any time, if a surrounding behavior may hold it longer."""
        for phase in ("end", "fail"):
            found = self.channels.between(number, phase, frame.start.t, frame.end.t)
            yield from (each.mark.seq for each in found[:1])

    def _declared(self, number: int, name: str, occurrences: list[LoggedEvent], explained: set[int]) -> None:
        """Check that each occurrence of an event has an emission or an occurrence of its source."""
        holder = self.world.holder(number)
        if holder is None:
            return
        declared = self.channels.event_of(holder, name)
        around = holder.declaration.span if isinstance(holder, Instance) else None
        span = declared.span if declared is not None else around
        seen: Counter[tuple[float, bool, str]] = Counter()
        for occurrence in occurrences:
            seq, t = occurrence.mark
            key = t, occurrence.is_derived, repr(sorted(occurrence.recorded["arguments"].items()))
            seen[key] += 1
            if seen[key] > 1:
                self.findings.violate(Rule.EVENT, f"`{name}` occurs twice at {t:g} s", span, seq)
            if occurrence.is_derived:
                self._derived(holder, occurrence)
                if not self.moments.received.check(number, name, t):
                    message = f"`{name}` occurs at {t:g} s, but no subscriber receives it then"
                    self.findings.violate(Rule.EVENT, message, span, seq)
            elif "origin" in occurrence.recorded:
                self._outside(occurrence, declared, span)
            elif isinstance(holder, Instance):
                if seq not in explained:
                    message = f"`{name}` occurs at {t:g} s without an `emit`"
                    self.findings.violate(Rule.EVENT, message, span, seq)
                if declared is not None:
                    self._fits(declared, occurrence)

    def _outside(self, occurrence: LoggedEvent, declared: Event | None, span: Span | None) -> None:
        """Check an external emission: the event must be declared external in `run.start`."""
        seq, t = occurrence.mark
        recorded, external = occurrence.recorded, self.history.run.get("external")
        is_external = isinstance(external, list) and _ATTEMPT.sub("", recorded["name"]) in external
        if recorded["origin"] != _APPLICATION or declared is None or not is_external:
            message = f"`{occurrence.name}` is emitted from outside at {t:g} s, but is not external in `run.start`"
            self.findings.violate(Rule.EVENT, message, span, 0, seq)
        if declared is not None:
            self._fits(declared, occurrence)

    def _all_received(self) -> None:
        """Check that a derived event occurs whenever a subscriber receives it."""
        for number, name, t in self.moments.received.due:
            if not any(occurrence.is_derived for occurrence in self.channels.at(number, name, t)):
                message = f"`{name}` does not occur at {t:g} s, when a subscriber receives it"
                self.findings.violate(Rule.EVENT, message, None)

    def _fits(self, declared: Event, occurrence: LoggedEvent) -> None:
        """Check the names of the arguments against the declaration."""
        recorded = occurrence.recorded["arguments"]
        parameters = {parameter for parameter, _ in declared.parameters}
        if set(recorded) != parameters:
            message = f"`{declared.name}` has the arguments {sorted(recorded)}; expected {sorted(parameters)}"
            self.findings.violate(Rule.EVENT, message, None, occurrence.mark.seq)

    def _derived(self, holder: Instance | Struct | Actor, occurrence: LoggedEvent) -> None:
        """Check that the source of a derived event has occurred; the start of its context is unknown."""
        name = occurrence.name
        declared = self.channels.event_of(holder, name)
        specification = declared.specification if declared is not None else None
        if declared is None or specification is None:
            message = f"`{name}` occurs, but is neither emitted nor derived"
            span = holder.declaration.span if isinstance(holder, Instance) else None
            self.findings.violate(Rule.EVENT, message, span, occurrence.mark.seq)
            return
        entry = self.world.instances[self.history.root.instances[0]]
        environment = self.world.scope_of(holder, entry.environment)
        if isinstance(specification, Holds | Rise | Fall):
            self._condition(specification, environment, occurrence, declared.span)
        if not isinstance(specification, OnEvent) or not isinstance(
            specification.event, DeclaredEvent | PhaseEvent
        ):
            return
        with self.findings.undecided(Rule.EVENT, declared.span):
            channels = list(self.channels.resolve(specification.event, environment, occurrence.mark))
            if not any(self.channels.at(channel.of, channel.name, occurrence.mark.t) for channel in channels):
                message = f"`{name}` occurs, but its source does not"
                self.findings.violate(Rule.EVENT, message, declared.span, occurrence.mark.seq)

    def _condition(
        self, condition: Holds | Rise | Fall, environment: Environment, occurrence: LoggedEvent, span: Span
    ) -> None:
        """Check that the condition of a derived event holds."""
        with self.findings.undecided(Rule.EVENT, span):
            values = self.moments.values_at(condition.condition, environment, occurrence.mark.t)
            if (not isinstance(condition, Fall)) not in values:
                message = f"`{occurrence.name}` occurs at {occurrence.mark.t:g} s, but its condition does not hold"
                self.findings.violate(Rule.EVENT, message, span, occurrence.mark.seq)
