"""`wait`, `until` and `duration`: what ends not before and not after its time (7.6.2.4, 7.6.2.5.3, 7.6.2.5.4)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import inf, nextafter

from seoro.lang.plan import Expression, OneOf, Serial, Wait
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Findings, Rule, Undecided
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Frame, Matched
from seoro.runtime.accept.history import History, Node
from seoro.runtime.accept.layers import Duration, Untils
from seoro.runtime.accept.moments import Listening, Moment, Moments
from seoro.runtime.accept.pasts import Pasts
from seoro.runtime.accept.timing import Timing
from seoro.runtime.accept.world import Instance, World
from seoro.runtime.environment import Environment
from seoro.runtime.values import Range


@dataclass(eq=False)
class Waiting:
    """Checks what waits.

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
        """Check all of it."""
        for plan, node, instance in matched.waits:
            self._wait(plan, node, instance)
        for layer, frame, environment in matched.untils:
            self._until(layer, frame, environment)
        timing = Timing(self.world, matched)
        for duration, frame, it in matched.durations:
            self._duration(duration, frame, it, timing)

    def _wait(self, plan: Wait, node: Node, instance: Instance) -> None:
        past = partial(self.pasts.before, node, node.start)
        # What ends by its event has heard it; what is cancelled in that instant may not have.
        heard_until = nextafter(node.end.t, inf) if node.status == SUCCEEDED else node.end.t
        listening = Listening(node.start, node.end.t, instance.environment, past, heard_until)
        try:
            found = self.moments.of(plan.event, listening)
        except Undecided as why:
            self.findings.skip(Rule.WAIT, why, plan.span)
            return
        end = node.end.t
        if node.status == SUCCEEDED and not any(moment.first <= end <= moment.last for moment in found):
            self._not_met(Rule.WAIT, plan.span, end, found, node.records)
        if node.status == FAILED:
            self.findings.violate(Rule.OUTCOME, "a `wait` cannot fail", plan.span, *node.records)
        self._check_overdue(Rule.WAIT, plan.span, found, end, node.records, is_cut=node.status == CANCELLED)

    def _until(self, layer: Untils, frame: Frame, environment: Environment) -> None:
        past = partial(self.pasts.before, frame.node, frame.start)
        heard_until = frame.start.t if frame.held else frame.end.t  # what is held may have ended
        if not frame.held and frame.status == SUCCEEDED and len(layer.directives) == 1:
            heard_until = nextafter(frame.end.t, inf)
        listening = Listening(frame.start, frame.end.t, environment, past, heard_until)
        span = layer.directives[0].span
        found: list[Moment] = []
        for directive in layer.directives:
            try:
                found += self.moments.of(directive.event, listening)
            except Undecided as why:
                self.findings.skip(Rule.UNTIL, why, directive.span)
                return
        end = frame.end.t
        if frame.status == SUCCEEDED and not any(self._ends_with(moment, end) for moment in found):
            self._not_met(Rule.UNTIL, span, end, found, frame.records)
        self._check_overdue(Rule.UNTIL, span, found, end, frame.records, is_cut=True)

    def _ends_with(self, moment: Moment, end: float) -> bool:
        return moment.first <= end and (end <= moment.last or self.history.lasts(moment.last, end))

    def _not_met(self, rule: Rule, span: Span, end: float, found: list[Moment], records: tuple[int, ...]) -> None:
        shown = [
            moment.happening.mark.seq for moment in found if moment.happening is not None and moment.first > end
        ]
        message = f"it ends at {end:g} s, and what it waits for has not occurred then"
        self.findings.violate(rule, message, span, *records, *shown[:1])

    def _check_overdue(
        self, rule: Rule, span: Span, found: list[Moment], end: float, records: tuple[int, ...], *, is_cut: bool
    ) -> None:
        """What was met before the end should have ended it."""
        for moment in found:
            if moment.sure and moment.last < end and not (is_cut and self.history.lasts(moment.last, end)):
                shown = (moment.happening.mark.seq,) if moment.happening is not None else ()
                message = f"it lasts until {end:g} s, and what it waits for occurs at {moment.last:g} s"
                self.findings.violate(rule, message, span, *records, *shown)
                return

    def _duration(self, layer: Duration, frame: Frame, it: Instance | None, timing: Timing) -> None:
        span, windows = layer.span, [Range(0.0, inf)]
        try:
            if layer.expression is not None:
                windows.append(self._argument(layer.expression, frame, it))
            said = timing.duration(layer.behavior, frame, it)
        except Undecided as why:
            self.findings.skip(Rule.DURATION, why, span)
            return
        if said is not None:
            windows.append(said.bounds)
        bounds = Range(max(each.low for each in windows), min(each.high for each in windows))
        self._within(bounds, frame, span)
        if said is None or said.is_all:
            if not timing.matched.overrides:  # which may end members, too
                self._check_cut(layer, frame, bounds.high)
        else:
            self.findings.skip(Rule.DURATION, "constraints that others may override, or that leave a choice", span)

    def _check_cut(self, layer: Duration, frame: Frame, most: float) -> None:
        """Something that ends with nothing that has ended so is ended at its upper bound."""
        if not isinstance(layer.behavior, Serial | OneOf) or frame.held or frame.status in frame.cuts:
            return
        statuses = {child.status for child in frame.children}
        if frame.status not in statuses and statuses and frame.end.t < self.history.reached(frame.start.t + most):
            message = (
                f"it {frame.status} at {frame.end.t:g} s, with nothing that has {frame.status}, and may last until"
            )
            self.findings.violate(
                Rule.DURATION, f"{message} {frame.start.t + most:g} s", layer.span, *frame.records
            )

    def _argument(self, expression: Expression, frame: Frame, it: Instance | None) -> Range:
        environment = frame.around.environment
        if it is not None:
            environment = replace(environment, bindings={**environment.bindings, "it": it})
        bounds, text = self.world.value(expression, environment, frame.start.seq), expression.span.text
        if not isinstance(bounds, Range):
            raise Undecided(f"`{text}` is no range")
        if bounds.low < 0:
            raise Undecided(f"`{text}` is {bounds.low:g} s, which no duration can be")
        return bounds

    def _within(self, bounds: Range, frame: Frame, span: Span) -> None:
        """What is carried out in a frame lasts as long as it may and has to."""
        start, end = frame.start.t, frame.end.t
        if not frame.held and frame.status == SUCCEEDED and end < start + bounds.low - 1e-9:
            message = f"it lasts {end - start:g} s, and should at least {bounds.low:g} s"
            self.findings.violate(Rule.DURATION, message, span, *frame.records)
        # What `until` holds lasts longer; what is carried out in it does not.
        ends = [child.end.t for child in frame.children] if frame.held else [end]
        latest = self.history.reached(start + bounds.high)
        for each in ends:
            if each > latest and not self.history.lasts(latest, each):
                message = f"it lasts {each - start:g} s, and should at most {bounds.high:g} s"
                self.findings.violate(Rule.DURATION, message, span, *frame.records)
