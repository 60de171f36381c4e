"""Modifiers of `osc.helpers`: their ends follow from those of the modified behaviors; `override` (7.3.12.1.1).

The rules of other libraries are unknown; they are reported as unchecked. With an override, the start of a behavior
ends another one, or keeps it from starting.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from seoro.lang import plan as plan_
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.frames import (
    CANCELLED,
    FAILED,
    SUCCEEDED,
    Checker,
    Frame,
    Matched,
    ended,
    was_overridden,
)
from seoro.runtime.accept.history import Node
from seoro.runtime.accept.instances import Instance

_LIBRARY: Final = "osc.helpers"
_LIMITED: Final = frozenset({"timeout", "running_is_failure", "running_is_success"})
_OUTCOMES: Final[
    Mapping[str, Mapping[str, str]]
] = {  # of the modifier, by that of the attempt; cancelled: it holds
    "inverter": {SUCCEEDED: FAILED, FAILED: SUCCEEDED},
    "failure_is_success": {SUCCEEDED: SUCCEEDED, FAILED: SUCCEEDED},
    "success_is_failure": {SUCCEEDED: FAILED, FAILED: FAILED},
    "success_is_running": {SUCCEEDED: CANCELLED, FAILED: FAILED},
    "failure_is_running": {SUCCEEDED: SUCCEEDED, FAILED: CANCELLED},
    "timeout": {SUCCEEDED: SUCCEEDED, FAILED: FAILED, CANCELLED: FAILED},
    "running_is_failure": {SUCCEEDED: SUCCEEDED, FAILED: FAILED, CANCELLED: FAILED},
    "running_is_success": {SUCCEEDED: SUCCEEDED, FAILED: FAILED, CANCELLED: SUCCEEDED},
}


class ModifierChecker(Checker):
    """Check of modifiers."""

    def check(self, matched: Matched) -> None:
        """Check all modifiers."""
        overridden = matched.overridden
        for application, modifier, node, _ in matched.modifiers:
            for span in (*(on.span for on in modifier.on), *(sample.span for sample in modifier.samples)):
                reason = "the reactions of a modifier are not decided, except that they end the modified behavior"
                self.findings.skip(Rule.MODIFIER, reason, span)
            if modifier.library == _LIBRARY:
                self._check(application, modifier, node, _outcomes(node, overridden))
            elif modifier.library is not None or node.attempts:
                reason = f"`{modifier.name}` is implemented in Python with unknown rules"
                self.findings.skip(Rule.MODIFIER, reason, application.span)

    def _check(
        self, application: plan_.ModifierApplication, modifier: plan_.Modifier, node: Node, outcomes: Sequence[str]
    ) -> None:
        def wrong(message: str, *records: int) -> None:
            self.findings.violate(Rule.MODIFIER, message, application.span, *node.records, *records)

        attempts = node.attempts
        self._check_times(node, wrong)
        if modifier.name in ("repeat", "retry"):
            self._check_again(modifier.name, node, outcomes, wrong)
            return
        if len(attempts) > 1:
            wrong(
                f"`{modifier.name}` runs the behavior {len(attempts)} times; expected once", attempts[1].start.seq
            )
        if modifier.name in _LIMITED:
            self._check_limit(modifier.name, node, wrong)
        if not attempts or node.status == CANCELLED:
            return
        outcome = attempts[0].status if modifier.name in _LIMITED else outcomes[0]
        due = _OUTCOMES.get(modifier.name, {}).get(outcome)
        if due != node.status:
            wrong(f"`{modifier.name}` {node.status}, but the behavior {ended(outcome)}", attempts[0].end.seq)

    def _check_times(self, node: Node, wrong: Callable[..., None]) -> None:
        """Check that each attempt starts when the previous one has ended, the first with the modifier."""
        due, seq = node.start.t, node.start.seq
        for attempt in node.attempts:
            if attempt.start.t != due:
                wrong(f"an attempt starts at {attempt.start.t:g} s; expected {due:g} s", seq, attempt.start.seq)
            due, seq = attempt.end.t, attempt.end.seq
        if node.attempts and node.status != CANCELLED and node.end.t != due:
            wrong(f"it ends at {node.end.t:g} s, but the behavior at {due:g} s", seq)

    def _check_again(self, name: str, node: Node, outcomes: Sequence[str], wrong: Callable[..., None]) -> None:
        """Check the attempts of `repeat`, which continues after success, and `retry`, after failure."""
        count, attempts = node.arguments.get("count"), node.attempts
        goes_on = SUCCEEDED if name == "repeat" else FAILED
        for attempt, outcome in zip(attempts[:-1], outcomes, strict=False):
            if outcome != goes_on:
                wrong(f"`{name}` continues after an attempt that {ended(outcome)}", attempt.end.seq)
        if not isinstance(count, int):
            wrong("its count is missing")
            return
        if 0 <= count < len(attempts):
            wrong(f"`{name}` makes {len(attempts)} attempts; expected {count}", attempts[count].start.seq)
        if node.status == CANCELLED or not attempts:
            return
        last = attempts[-1]
        if outcomes[-1] == goes_on and len(attempts) != count:
            wrong(f"`{name}` ends after {len(attempts)} attempts; expected {_times(count)}", last.end.seq)
        if last.status != node.status:
            wrong(f"`{name}` {node.status}, but its last attempt {ended(last.status)}", last.end.seq)

    def _check_limit(self, name: str, node: Node, wrong: Callable[..., None]) -> None:
        """Check that attempts are cancelled at the time limit, and not before."""
        limit: Any = node.arguments.get("duration") if name == "timeout" else 0.0
        if not isinstance(limit, int | float):
            wrong("its duration is missing")
            return
        latest = self.history.reached(node.start.t + limit)
        for attempt in node.attempts:
            is_cut = attempt.status == CANCELLED and self.history.lasts(latest, attempt.end.t)
            if attempt.end.t > latest and not is_cut:
                wrong(f"the behavior lasts longer than {limit:g} s", attempt.end.seq)
            elif attempt.status == CANCELLED and node.status != CANCELLED and attempt.end.t < latest:
                wrong(f"the behavior is cancelled before {limit:g} s have passed", attempt.end.seq)


def _outcomes(node: Node, overridden: frozenset[str]) -> list[str]:
    """Return the end states of the attempts of a modifier; overridden ones count as succeeded."""
    found = []
    for attempt in node.attempts:
        within = (each for each in node.children if attempt.start.seq < each.start.seq < attempt.end.seq)
        is_cancelled = attempt.status == CANCELLED
        found.append(SUCCEEDED if is_cancelled and was_overridden(within, overridden) else attempt.status)
    return found


def _times(count: int) -> str:
    return "any number" if count < 0 else str(count)


class OverrideChecker(Checker):
    """Check of overrides."""

    def check(self, matched: Matched) -> None:
        """Check all overrides, each within the frame of the modified behavior."""
        nodes: dict[tuple[int, str], list[Node]] = {}
        for label, node, around in matched.labels:
            nodes.setdefault((around.number, label), []).append(node)
        for override, frame, instance in matched.overrides:
            if frame.is_cut_at_once:
                continue  # it may have been ended before the override was active
            overridden = self._labelled(override.overridden, instance, nodes)
            by = self._labelled(override.by, instance, nodes)
            for node in overridden:
                self._check(override, frame, node, by)

    def _labelled(
        self, path: plan_.LabelPath, instance: Instance, nodes: dict[tuple[int, str], list[Node]]
    ) -> list[Node]:
        """Return the behaviors that a path of labels leads to."""
        holders = [instance]
        for label in path[:-1]:
            holders = [each for holder in holders for each in holder.labels.get(label, ())]
        return [node for holder in holders for node in nodes.get((holder.number, path[-1]), ())]

    def _check(self, override: plan_.Override, frame: Frame, node: Node, by: list[Node]) -> None:
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
            if is_active and override.mode is plan_.OverrideMode.WHEN_ACTIVE:
                message = f"`{node.name}` starts while `{other.name}` is active, which overrides it"
                self.findings.violate(Rule.OVERRIDE, message, override.span, other.start.seq, node.start.seq)

    def _last(self, frame: Frame) -> int:
        """Return the last record at which the modified behavior runs; held behaviors end with their members."""
        if not frame.held:
            return frame.end.seq
        return max((child.end.seq for child in frame.children), default=frame.start.seq)
