"""`serial` and `one_of` (7.6.2.1.2, 7.6.2.1.3), and the base of the checks of compositions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import ClassVar

from seoro.lang.plan import Behavior, Composition, Serial, Wait
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.frames import (
    CANCELLED,
    FAILED,
    SUCCEEDED,
    UNKNOWN,
    Checker,
    End,
    Frame,
    Location,
    kind_of,
    location_of,
    recorded_location,
    title_of,
)
from seoro.runtime.accept.history import Mark, Node


@dataclass(eq=False)
class CompositionChecker(Checker, ABC):
    """Check of a composition in a frame.

    Args:
        plan: The composition.
        frame: Its frame.
    """

    rule: ClassVar[Rule]
    plan: Composition
    frame: Frame
    may_end_secondaries: bool = field(default=False, init=False)  # whether it ends open-ended members

    def __post_init__(self) -> None:
        self.nodes = self._place()

    def _place(self) -> dict[int, Node]:
        """Match behaviors of the trace with members, and return them by index; report others."""
        members = self.plan.members
        positions: dict[tuple[str, Location], int] = {}
        for index, member in enumerate(members):
            positions.setdefault((kind_of(member), location_of(member.span)), index)
        placed: dict[int, Node] = {}
        for node in self.frame.children:
            found = positions.get((node.type, recorded_location(node)))
            if found is None:
                self.violate(f"`{node.name}` is not a member of it", self.plan.span, node.start.seq)
            elif found in placed:
                self.violate(f"`{node.name}` runs twice", members[found].span, node.start.seq)
            else:
                placed[found] = node
        return placed

    @abstractmethod
    def end(self) -> End:
        """Check the members; return the end of the composition."""

    def violate(self, message: str, span: Span, *records: int) -> None:
        """Report a violation of the rule for the composition."""
        self.findings.violate(self.rule, message, span, *records)

    @property
    def missing(self) -> list[Behavior]:
        """Members that have not started."""
        return [member for index, member in enumerate(self.plan.members) if index not in self.nodes]

    def may_be_overridden(self, member: Behavior) -> bool:
        """Whether an `override` may end a member, or keep it from starting."""
        return member.label in self.world.overridden

    def check_cancelled(self, nodes: Iterable[Node]) -> None:
        """Check that members are cancelled with the whole composition, unless an `override` ended them before.

        Args:
            nodes: Members that nothing else may have ended before.
        """
        if self.frame.loosened > 1:
            return  # a surrounding behavior may have ended it before
        end = self.frame.end
        for node in nodes:
            is_left = node.status == CANCELLED and not self.history.lasts(node.end.t, end.t)
            if is_left and not self.was_overridden(node):
                message = f"`{node.name}` is cancelled at {node.end.t:g} s, but all of it at {end.t:g} s"
                self.violate(message, self.plan.span, node.end.seq, end.seq)


class SerialChecker(CompositionChecker):
    """Check of a `serial`."""

    rule = Rule.SERIAL

    def end(self) -> End:
        """Check the order and the starts of members; return the end of the last one."""
        members, following = self.plan.members, 0
        last: Node | None = None
        for index, node in self.nodes.items():
            due = last.end if last is not None else self.frame.start
            if index < following:
                self.violate(f"`{node.name}` is out of order", members[index].span, due.seq, node.start.seq)
                continue
            for missing in members[following:index]:
                if not self.may_be_overridden(missing):
                    self.violate(f"`{title_of(missing)}` is missing", missing.span, due.seq, node.start.seq)
            self._check_next(node, members[index].span, due, last)
            following, last = index + 1, node
        end = self.end_of(last) if last is not None else End(SUCCEEDED, self.frame.start.t)
        rest = members[following:]
        if end.status != SUCCEEDED or not rest:
            return end
        return UNKNOWN if all(map(self.may_be_overridden, rest)) else replace(end, status=None)

    def _check_next(self, node: Node, span: Span, due: Mark, before: Node | None) -> None:
        """Check that a member starts when the previous one has ended without failure.

        Args:
            node: The member in the trace.
            span: The member in the plan.
            due: Its expected start.
            before: The previous member in the trace.
        """
        if before is not None and before.status == FAILED:
            rule, message = Rule.OUTCOME, f"`{node.name}` starts after a member has failed"
        elif before is not None and before.status == CANCELLED and not self.was_overridden(before):
            rule, message = Rule.OUTCOME, f"`{node.name}` starts after a member was cancelled"
        elif node.start.t != due.t:
            rule, t = self.rule, f"{node.start.t:g} s"
            message = f"`{node.name}` starts at {t}; expected {due.t:g} s, the end of its predecessor"
        else:
            return
        self.findings.violate(rule, message, span, due.seq, node.start.seq)


class OneOfChecker(CompositionChecker):
    """Check of a `one_of`."""

    rule = Rule.ONE_OF

    def _check_starts(self) -> None:
        """Check that guarded members wait from the start, and that others are invoked after failures only."""
        frame, members = self.frame, self.plan.members
        for member in filter(_is_guarded, self.missing):
            if not (self._may_lack(frame.start.t) or self.may_be_overridden(member)):
                self.violate(f"`{title_of(member)}` does not wait", member.span, *frame.records)
        due, has_guarded = frame.start, False
        previous: Node | None = None
        for index, node in self.nodes.items():
            span = members[index].span
            if _is_guarded(members[index]):
                has_guarded = True
                if node.start.t != frame.start.t:
                    self.violate(f"`{node.name}` waits too late", span, frame.start.seq, node.start.seq)
                continue
            if previous is not None and previous.status != FAILED:
                message = f"`{node.name}` is invoked, but `{previous.name}` was invoked before and has not failed"
                self.violate(message, span, previous.start.seq, node.start.seq)
            elif node.start.t != due.t:
                message = f"`{node.name}` starts at {node.start.t:g} s; expected {due.t:g} s"
                self.violate(message, span, due.seq, node.start.seq)
            due, previous = node.end, node
        others = [member for member in members if not _is_guarded(member)]
        is_skipped = (any if has_guarded else all)(map(self.may_be_overridden, others))  # guarded ones suffice
        if previous is None and others and not is_skipped and not self._may_lack(frame.start.t):
            self.violate("no member is invoked", self.plan.span, *frame.records)

    def _may_lack(self, due: float) -> bool:
        """Whether a due member may be missing."""
        decided = any(node.end.t == due and node.status != CANCELLED for node in self.nodes.values())
        return decided or self.history.lasts(due, self.frame.end.t)

    def end(self) -> End:
        """Check the choice of a member; return its end."""
        self._check_starts()
        found = {index: self._decision(index, node) for index, node in self.nodes.items()}
        decisions = {index: mark for index, mark in found.items() if mark is not None}
        if not decisions:
            return self._undecided_end()
        choice = min(decisions, key=decisions.__getitem__)
        chosen, decision = self.nodes[choice], decisions[choice]
        for index, node in self.nodes.items():
            if node is chosen:
                continue
            if node.status == CANCELLED and node.end.t < decision.t:
                self.check_cancelled([node])
            elif index in decisions:
                message = f"`{node.name}` continues after its guard, but `{chosen.name}` was chosen"
                self.violate(message, self.plan.span, *chosen.records, *node.records)
            elif not self.history.lasts(decision.t, node.end.t) and node.end.t > decision.t:
                message = f"`{node.name}` is still running after `{chosen.name}` was chosen"
                self.violate(message, self.plan.members[index].span, decision.seq, node.end.seq)
        end = self.end_of(chosen)
        latest = max(node.end.t for node in self.nodes.values())
        return replace(end, t=latest) if end.status in (SUCCEEDED, FAILED) else end

    def _decision(self, index: int, node: Node) -> Mark | None:
        """Return the place of the choice of a member; None if it was not chosen."""
        deciding = node
        if _is_guarded(self.plan.members[index]):
            while deciding.type != "wait" and deciding.children:
                deciding = deciding.children[0]
            if deciding.type != "wait":
                return None
            if deciding.status != SUCCEEDED:
                deciding = node  # an `until` may have ended it before its guard was met
        return deciding.end if deciding.status == SUCCEEDED else None

    def _undecided_end(self) -> End:
        nodes, missing = self.nodes.values(), self.missing
        self.check_cancelled(nodes)
        is_skipped = bool(missing) and all(map(self.may_be_overridden, missing))
        if is_skipped or any(self.end_of(node) is UNKNOWN for node in nodes):
            return UNKNOWN
        if nodes and all(node.status == FAILED for node in nodes):
            last = max(nodes, key=lambda node: node.end)
            return End(None if missing else FAILED, last.end.t, last.records)  # without failure, the next was due
        return End(None, max((node.end.t for node in nodes), default=self.frame.start.t))


def _is_guarded(member: Behavior) -> bool:
    """Whether a member begins with a `wait`, possibly within `serial`."""
    while isinstance(member, Serial) and member.members:
        member = member.members[0]
    return isinstance(member, Wait)
