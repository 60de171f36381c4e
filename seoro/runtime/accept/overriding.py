"""`override` (7.3.12.1.1): the start of a behavior ends another one, or keeps it from starting."""

from __future__ import annotations

from collections.abc import Iterable

from seoro.lang.plan import (
    LabelPath,
    Modification,
    Override,
    OverrideMode,
    Plan,
)
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.frames import CANCELLED, Frame, Matched, behaviors_in
from seoro.runtime.accept.history import Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.world import Checker


class OverrideChecker(Checker):
    """Check of overrides."""

    def check(self, matched: Matched) -> None:
        """Check all overrides, each within the frame of the modified behavior."""
        nodes: dict[tuple[int, str], list[Node]] = {}
        for label, node, around in matched.labels:
            nodes.setdefault((around.number, label), []).append(node)
        for override, frame, instance in matched.overrides:
            if frame.start.t == frame.end.t and frame.status in frame.cuts:
                continue  # it may have been ended before the override was active
            overridden = self._labelled(override.overridden, instance, nodes)
            by = self._labelled(override.by, instance, nodes)
            for node in overridden:
                self._check(override, frame, node, by)

    def _labelled(
        self, path: LabelPath, instance: Instance, nodes: dict[tuple[int, str], list[Node]]
    ) -> list[Node]:
        """Return the behaviors that a path of labels leads to."""
        holders = [instance]
        for label in path[:-1]:
            holders = [each for holder in holders for each in holder.labels.get(label, ())]
        return [node for holder in holders for node in nodes.get((holder.number, path[-1]), ())]

    def _check(self, override: Override, frame: Frame, node: Node, by: list[Node]) -> None:
        """Check one behavior that others override."""
        last = self._last(frame)
        for other in by:
            if other is node:
                continue
            is_held = frame.start.seq <= other.start.seq <= last
            starts_in_it = is_held and node.start.t < other.start.t < node.end.t
            if starts_in_it and not (node.status == CANCELLED and self.history.lasts(other.start.t, node.end.t)):
                message = f"`{node.name}` continues when `{other.name}` starts, which overrides it"
                self.findings.violate(
                    Rule.OVERRIDE, message, override.span, node.start.seq, other.start.seq, node.end.seq
                )
            is_held = frame.start.t < node.start.t and node.start.seq <= last
            is_active = is_held and other.start.t < node.start.t < other.end.t
            if is_active and override.mode is OverrideMode.WHEN_ACTIVE:
                message = f"`{node.name}` starts while `{other.name}` is active, which overrides it"
                self.findings.violate(Rule.OVERRIDE, message, override.span, other.start.seq, node.start.seq)

    def _last(self, frame: Frame) -> int:
        """Return the last record at which the modified behavior runs; held behaviors end with their members."""
        if not frame.held:
            return frame.end.seq
        return max((child.end.seq for child in frame.children), default=frame.start.seq)


def overrides_in(plan: Plan) -> list[Override]:
    """Return all overrides of a plan."""
    found = [each for modifier in plan.modifiers.values() for each in _overrides(modifier.modifiers)]
    for scenario in plan.scenarios.values():
        found += _overrides(scenario.modifiers)
        for behavior in behaviors_in(scenario):
            found += _overrides(getattr(behavior, "modifications", ()))
    return found


def _overrides(modifications: Iterable[Modification]) -> list[Override]:
    return [each for each in modifications if isinstance(each, Override)]
