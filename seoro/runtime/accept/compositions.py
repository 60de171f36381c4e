"""`serial` and `one_of` (7.6.2.1.2, 7.6.2.1.3), and the scenario's `do` (7.6.2.1.1)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from seoro.lang.plan import Behavior, OneOf, Serial, Wait
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.frames import (
    CANCELLED,
    FAILED,
    SUCCEEDED,
    UNKNOWN,
    End,
    Frame,
    Location,
    kind_of,
    location_of,
    recorded_location,
    title_of,
)
from seoro.runtime.accept.history import History, Node


def was_overridden(nodes: Iterable[Node], overridden: frozenset[str]) -> bool:
    """Whether an `override` may have cancelled one of the behaviors, directly or within it.

    Args:
        nodes: The behaviors.
        overridden: Labels of behaviors that an `override` may end.
    """
    pending = list(nodes) if overridden else []
    while pending:
        found = pending.pop()
        if found.status == CANCELLED:
            if found.name in overridden:
                return True
            pending += found.children
    return False


@dataclass(frozen=True)
class Checking:
    """Shared data of checks of compositions.

    Args:
        history: The trace.
        findings: Collects violations.
        overridden: Labels of behaviors that an `override` may end or keep from starting.
    """

    history: History
    findings: Findings
    overridden: frozenset[str]

    def may_be_overridden(self, member: Behavior) -> bool:
        """Whether an `override` may end a member, or keep it from starting."""
        return member.label in self.overridden

    def was_overridden(self, node: Node) -> bool:
        """Whether an `override` may have cancelled a behavior, directly or within it."""
        return was_overridden([node], self.overridden)

    def end_of(self, node: Node) -> End:
        """Return the end of the last running member."""
        if node.status == CANCELLED:
            return UNKNOWN if self.was_overridden(node) else End(None, node.end.t, node.records)
        return End(node.status, node.end.t, node.records)

    def check_cancelled(self, frame: Frame, nodes: Iterable[Node], rule: Rule, span: Span) -> None:
        """Check that members are cancelled with the whole composition, unless an `override` ended them before.

        Args:
            frame: Frame of the composition.
            nodes: Members that nothing else may have ended before.
            rule: The rule to report.
            span: The composition.
        """
        if frame.loosened > 1:
            return  # a surrounding behavior may have ended it before
        for node in nodes:
            is_left = node.status == CANCELLED and not self.history.lasts(node.end.t, frame.end.t)
            if is_left and not self.was_overridden(node):
                message = f"`{node.name}` is cancelled at {node.end.t:g} s, but all of it at {frame.end.t:g} s"
                self.findings.violate(rule, message, span, node.end.seq, frame.end.seq)

    def place_members(
        self, members: Sequence[Behavior], nodes: Sequence[Node], rule: Rule, span: Span
    ) -> list[tuple[int, Node]]:
        """Match behaviors of the trace with members, and return them with their indices; report others."""
        positions: dict[tuple[str, Location], int] = {}
        for index, member in enumerate(members):
            positions.setdefault((kind_of(member), location_of(member.span)), index)
        placed: dict[int, Node] = {}
        for node in nodes:
            found = positions.get((node.type, recorded_location(node)))
            if found is None:
                self.findings.violate(rule, f"`{node.name}` is not a member of it", span, node.start.seq)
            elif found in placed:
                span_of_member = members[found].span
                self.findings.violate(rule, f"`{node.name}` runs twice", span_of_member, node.start.seq)
            else:
                placed[found] = node
        return list(placed.items())


def end_of_serial(plan: Serial, frame: Frame, checking: Checking) -> tuple[list[tuple[Behavior, Node]], End]:
    """Check a `serial`; return its members in the trace and its end."""
    findings, members = checking.findings, plan.members
    placed = checking.place_members(members, frame.children, Rule.SERIAL, plan.span)
    due, seq, following = frame.start.t, frame.start.seq, 0
    last: tuple[int, Node] | None = None
    for index, node in placed:
        if index < following:
            findings.violate(
                Rule.SERIAL, f"`{node.name}` is out of order", members[index].span, seq, node.start.seq
            )
            continue
        for missing in members[following:index]:
            if not checking.may_be_overridden(missing):
                message = f"`{title_of(missing)}` is missing"
                findings.violate(Rule.SERIAL, message, missing.span, seq, node.start.seq)
        _check_next(node, members[index], (due, seq), last[1] if last is not None else None, checking)
        due, seq, following, last = node.end.t, node.end.seq, index + 1, (index, node)
    return [(members[index], node) for index, node in placed], _serial_end(plan, frame, last, checking)


def _check_next(
    node: Node, member: Behavior, due: tuple[float, int], before: Node | None, checking: Checking
) -> None:
    """Check that a member starts when the previous one has ended without failure.

    Args:
        node: The member in the trace.
        member: The member in the plan.
        due: Expected start [s], and the record that determines it.
        before: The previous member in the trace.
        checking: Shared data of checks.
    """
    t, seq = due
    if before is not None and before.status == FAILED:
        rule, message = Rule.OUTCOME, f"`{node.name}` starts after a member has failed"
    elif before is not None and before.status == CANCELLED and not checking.was_overridden(before):
        rule, message = Rule.OUTCOME, f"`{node.name}` starts after a member was cancelled"
    elif node.start.t != t:
        rule = Rule.SERIAL
        message = f"`{node.name}` starts at {node.start.t:g} s; expected {t:g} s, the end of its predecessor"
    else:
        return
    checking.findings.violate(rule, message, member.span, seq, node.start.seq)


def _serial_end(plan: Serial, frame: Frame, last: tuple[int, Node] | None, checking: Checking) -> End:
    members = plan.members
    if last is None:
        if all(map(checking.may_be_overridden, members)):
            return End(SUCCEEDED, frame.start.t) if not members else UNKNOWN
        return End(None, frame.start.t)
    index, node = last
    end = checking.end_of(node)
    if end is UNKNOWN or end.status != SUCCEEDED:
        return end
    rest = members[index + 1 :]
    if all(map(checking.may_be_overridden, rest)):
        return end if not rest else UNKNOWN
    return End(None, node.end.t, node.records)


def end_of_one_of(plan: OneOf, frame: Frame, checking: Checking) -> tuple[list[tuple[Behavior, Node]], End]:
    """Check a `one_of`; return its members in the trace and its end."""
    placed = checking.place_members(plan.members, frame.children, Rule.ONE_OF, plan.span)
    choice = _Choice(plan, frame, placed, checking)
    choice.check_starts()
    return [(plan.members[index], node) for index, node in placed], choice.end()


class _Choice:
    """Check of a `one_of`; for the arguments see `end_of_one_of`."""

    def __init__(self, plan: OneOf, frame: Frame, placed: list[tuple[int, Node]], checking: Checking) -> None:
        self._plan = plan
        self._frame = frame
        self._checking = checking
        self._guarded = {index for index, member in enumerate(plan.members) if _is_guarded(member)}
        self._placed = placed

    def check_starts(self) -> None:
        """Check that guarded members wait from the start, and that others are invoked after failures only."""
        findings, frame, members = self._checking.findings, self._frame, self._plan.members
        started = {index for index, _ in self._placed}
        for index in sorted(self._guarded - started):
            if not (self._may_lack(frame.start.t) or self._checking.may_be_overridden(members[index])):
                findings.violate(
                    Rule.ONE_OF, f"`{title_of(members[index])}` does not wait", members[index].span, *frame.records
                )
        due, seq = frame.start.t, frame.start.seq
        previous: Node | None = None
        for index, node in self._placed:
            span = members[index].span
            if index in self._guarded:
                if node.start.t != frame.start.t:
                    findings.violate(
                        Rule.ONE_OF, f"`{node.name}` waits too late", span, *frame.records[:1], node.start.seq
                    )
                continue
            if previous is not None and previous.status != FAILED:
                message = f"`{node.name}` is invoked, but `{previous.name}` was invoked before and has not failed"
                findings.violate(Rule.ONE_OF, message, span, previous.start.seq, node.start.seq)
            elif node.start.t != due:
                message = f"`{node.name}` starts at {node.start.t:g} s; expected {due:g} s"
                findings.violate(Rule.ONE_OF, message, span, seq, node.start.seq)
            due, seq, previous = node.end.t, node.end.seq, node
        others = [member for index, member in enumerate(members) if index not in self._guarded]
        has_guarded = any(index in self._guarded for index in started)  # then no other member has to be invoked
        is_skipped = (any if has_guarded else all)(map(self._checking.may_be_overridden, others))
        if previous is None and others and not is_skipped and not self._may_lack(frame.start.t):
            findings.violate(Rule.ONE_OF, "no member is invoked", self._plan.span, *frame.records)

    def _may_lack(self, due: float) -> bool:
        """Whether a due member may be missing."""
        decided = any(node.end.t == due and node.status != CANCELLED for _, node in self._placed)
        return decided or self._checking.history.lasts(due, self._frame.end.t)

    def end(self) -> End:
        """Return the end of the chosen member."""
        findings, members, placed, frame = self._checking.findings, self._plan.members, self._placed, self._frame
        deciding = [
            (index, node, mark) for index, node in placed if (mark := self._decides(index, node)) is not None
        ]
        if not deciding:
            return self._undecided_end()
        _, chosen, decision = min(deciding, key=lambda each: each[2])
        for other, node in placed:
            if node is chosen:
                continue
            if node.status == CANCELLED and node.end.t < decision[0]:
                self._checking.check_cancelled(frame, [node], Rule.ONE_OF, self._plan.span)
            elif (other, node) in [(position, each) for position, each, _ in deciding]:
                message = f"`{node.name}` continues after its guard, but `{chosen.name}` was chosen"
                findings.violate(Rule.ONE_OF, message, self._plan.span, *chosen.records, *node.records)
            elif not self._checking.history.lasts(decision[0], node.end.t) and node.end.t > decision[0]:
                message = f"`{node.name}` is still running after `{chosen.name}` was chosen"
                findings.violate(Rule.ONE_OF, message, members[other].span, decision[1], node.end.seq)
        end = self._checking.end_of(chosen)
        latest = max(node.end.t for _, node in placed)
        return End(end.status, latest, end.records) if end.status in (SUCCEEDED, FAILED) else end

    def _decides(self, index: int, node: Node) -> tuple[float, int] | None:
        """Return the time and record of the choice of a member; None if it was not chosen."""
        deciding = node
        if index in self._guarded:
            while deciding.type != "wait" and deciding.children:
                deciding = deciding.children[0]
            if deciding.type != "wait":
                return None
            if deciding.status != SUCCEEDED:
                deciding = node  # an `until` may have ended it before its guard was met
        return (deciding.end.t, deciding.end.seq) if deciding.status == SUCCEEDED else None

    def _undecided_end(self) -> End:
        nodes = [node for _, node in self._placed]
        self._checking.check_cancelled(self._frame, nodes, Rule.ONE_OF, self._plan.span)
        members, started = self._plan.members, {index for index, _ in self._placed}
        missing = [member for index, member in enumerate(members) if index not in started]
        is_skipped = bool(missing) and all(map(self._checking.may_be_overridden, missing))
        if is_skipped or any(self._checking.end_of(node) is UNKNOWN for _, node in self._placed):
            return UNKNOWN
        failed = [node for _, node in self._placed if node.status == FAILED]
        if failed and len(failed) == len(self._plan.members):
            last = max(failed, key=lambda node: node.end)
            return End(FAILED, last.end.t, last.records)
        if failed and len(failed) == len(self._placed):
            last = max(failed, key=lambda node: node.end)
            return End(None, last.end.t, last.records)  # the next member was due
        ends = [node.end.t for _, node in self._placed]
        return End(None, max(ends, default=self._frame.start.t))


def _is_guarded(member: Behavior) -> bool:
    """Whether a member begins with a `wait`, possibly within `serial`."""
    while isinstance(member, Serial) and member.members:
        member = member.members[0]
    return isinstance(member, Wait)
