"""`wait`, `until` and `duration`: behaviors end exactly at their time (7.6.2.4, 7.6.2.5.3, 7.6.2.5.4)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nextafter

from seoro.lang.plan import Expression, OneOf, Serial, Wait
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Rule, Undecided
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Checker, Frame, Matched
from seoro.runtime.accept.history import Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.layers import Duration, Untils
from seoro.runtime.accept.moments import Listening, Moment, Moments
from seoro.runtime.accept.running import environment_in
from seoro.runtime.accept.timing import Timing
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Range


@dataclass(eq=False)
class WaitChecker(Checker):
    """Check of waiting behaviors.

    Args:
        moments: Finds when specifications are met.
    """

    moments: Moments

    def check(self, matched: Matched) -> None:
        """Check all waiting behaviors."""
        for plan, node, instance in matched.waits:
            self._wait(plan, node, instance)
        for layer, frame, environment in matched.untils:
            self._until(layer, frame, environment)
        timing = Timing(self.world, matched)
        for duration, frame, it in matched.durations:
            self._duration(duration, frame, it, timing)

    def _wait(self, plan: Wait, node: Node, instance: Instance) -> None:
        # A behavior that ends by its event has received it; one that is cancelled in that instant may not have.
        receives_until = nextafter(node.end.t, inf) if node.status == SUCCEEDED else node.end.t
        listening = Listening(node.start, node.end.t, instance.environment, node, receives_until)
        with self.findings.undecided(Rule.WAIT, plan.span):
            found = self.moments.of(plan.event, listening)
            end = node.end.t
            if node.status == SUCCEEDED and not any(moment.first <= end <= moment.last for moment in found):
                self._not_met(Rule.WAIT, plan.span, end, found, node.records)
            if node.status == FAILED:
                self.findings.violate(Rule.OUTCOME, "a `wait` cannot fail", plan.span, *node.records)
            self._check_overdue(Rule.WAIT, plan.span, found, end, node.records, is_cut=node.status == CANCELLED)

    def _until(self, layer: Untils, frame: Frame, environment: Environment) -> None:
        receives_until = frame.start.t if frame.held else frame.end.t  # held behaviors may have ended before
        if not frame.held and frame.status == SUCCEEDED and len(layer.directives) == 1:
            receives_until = nextafter(frame.end.t, inf)
        listening = Listening(frame.start, frame.end.t, environment, frame.node, receives_until)
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
        shown = [seq for moment in found if moment.first > end for seq in moment.records]
        message = f"it ends at {end:g} s, but its event has not occurred then"
        self.findings.violate(rule, message, span, *records, *shown[:1])

    def _check_overdue(
        self, rule: Rule, span: Span, found: list[Moment], end: float, records: tuple[int, ...], *, is_cut: bool
    ) -> None:
        """Check that no earlier occurrence should have ended it."""
        for moment in found:
            if moment.sure and moment.last < end and not (is_cut and self.history.lasts(moment.last, end)):
                message = f"it lasts until {end:g} s, but its event occurs at {moment.last:g} s"
                self.findings.violate(rule, message, span, *records, *moment.records)
                return

    def _duration(self, layer: Duration, frame: Frame, it: Instance | None, timing: Timing) -> None:
        span, windows = layer.span, [Range(0.0, inf)]
        with self.findings.undecided(Rule.DURATION, span):
            if layer.expression is not None:
                windows.append(self._argument(layer.expression, frame))
            window = timing.duration(layer.behavior, frame, it)
            if window is not None:
                windows.append(window.bounds)
            bounds = Range(max(each.low for each in windows), min(each.high for each in windows))
            self._within(bounds, frame, span)
            if window is None or window.is_all:
                if not timing.matched.overrides:  # overrides may end members too
                    self._check_cut(layer, frame, bounds.high)
            else:
                reason = "constraints may be overridden, or leave a choice"
                self.findings.skip(Rule.DURATION, reason, span)

    def _check_cut(self, layer: Duration, frame: Frame, most: float) -> None:
        """Check that a behavior that is still running at its upper bound ends there."""
        if not isinstance(layer.behavior, Serial | OneOf) or frame.held or frame.status in frame.cuts:
            return
        statuses = {child.status for child in frame.children}
        if frame.status not in statuses and statuses and frame.end.t < self.history.reached(frame.start.t + most):
            message = (
                f"it {frame.status} at {frame.end.t:g} s, but none of its content has {frame.status}; "
                f"expected to last until {frame.start.t + most:g} s"
            )
            self.findings.violate(Rule.DURATION, message, layer.span, *frame.records)

    def _argument(self, expression: Expression, frame: Frame) -> Range:
        environment, text = environment_in(frame, self.world), expression.span.text
        bounds = self.world.value(expression, environment, frame.start.seq)
        if not isinstance(bounds, Range):
            raise Undecided(f"`{text}` is not a range")
        if bounds.low < 0:
            raise Undecided(f"`{text}` is {bounds.low:g} s, an invalid duration")
        return bounds

    def _within(self, bounds: Range, frame: Frame, span: Span) -> None:
        """Check the duration of the content of a frame."""
        start, end = frame.start.t, frame.end.t
        if not frame.held and frame.status == SUCCEEDED and end < start + bounds.low - 1e-9:
            message = f"it lasts {end - start:g} s; expected at least {bounds.low:g} s"
            self.findings.violate(Rule.DURATION, message, span, *frame.records)
        # A behavior held by `until` lasts longer, but not its content.
        ends = [child.end.t for child in frame.children] if frame.held else [end]
        latest = self.history.reached(start + bounds.high)
        for each in ends:
            if each > latest and not self.history.lasts(latest, each):
                message = f"it lasts {each - start:g} s; expected at most {bounds.high:g} s"
                self.findings.violate(Rule.DURATION, message, span, *frame.records)
