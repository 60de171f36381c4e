"""`override` (7.3.12.1.1): a behavior ends when another starts, and while that is active does not start."""

from __future__ import annotations

from dataclasses import dataclass

from seoro.lang.plan import LabelPath, Override, OverrideMode
from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.frames import CANCELLED, Frame, Matched
from seoro.runtime.accept.history import History, Node
from seoro.runtime.accept.world import Instance


@dataclass(eq=False)
class Overriding:
    """Checks overrides.

    Args:
        history: The trace.
        findings: Gets what is wrong.
    """

    history: History
    findings: Findings

    def check(self, matched: Matched) -> None:
        """Check all of them, while they hold: in the frame of what they modify."""
        nodes: dict[tuple[int, str], list[Node]] = {}
        for label, node, around in matched.labels:
            nodes.setdefault((around.number, label), []).append(node)
        for override, frame, instance in matched.overrides:
            if frame.start.t == frame.end.t and frame.status in frame.cuts:
                continue  # it may have been ended before the override held
            overridden = self._labelled(override.overridden, instance, nodes)
            by = self._labelled(override.by, instance, nodes)
            for node in overridden:
                self._check(override, frame, node, by)

    def _labelled(
        self, path: LabelPath, instance: Instance, nodes: dict[tuple[int, str], list[Node]]
    ) -> list[Node]:
        """The behaviors that a path of labels leads to."""
        holders = [instance]
        for label in path[:-1]:
            holders = [each for holder in holders for each in holder.labels.get(label, ())]
        return [node for holder in holders for node in nodes.get((holder.number, path[-1]), ())]

    def _check(self, override: Override, frame: Frame, node: Node, by: list[Node]) -> None:
        """Check one behavior that is overridden by others."""
        last = self._last(frame)
        for other in by:
            if other is node:
                continue
            is_held = frame.start.seq <= other.start.seq <= last
            starts_in_it = is_held and node.start.t < other.start.t < node.end.t
            if starts_in_it and not (node.status == CANCELLED and self.history.lasts(other.start.t, node.end.t)):
                message = f"`{node.name}` goes on when `{other.name}` starts, which overrides it"
                self.findings.violate(
                    Rule.OVERRIDE, message, override.span, node.start.seq, other.start.seq, node.end.seq
                )
            is_held = frame.start.t < node.start.t and node.start.seq <= last
            is_active = is_held and other.start.t < node.start.t < other.end.t
            if is_active and override.mode is OverrideMode.WHEN_ACTIVE:
                message = f"`{node.name}` starts while `{other.name}` is active, which overrides it"
                self.findings.violate(Rule.OVERRIDE, message, override.span, other.start.seq, node.start.seq)

    def _last(self, frame: Frame) -> int:
        """The last record at which what an override modifies runs; what is held has ended with its members."""
        if not frame.held:
            return frame.end.seq
        return max((child.end.seq for child in frame.children), default=frame.start.seq)
