"""`parallel` (7.6.2.1.4): timing of its members relative to the first, the primary one.

A secondary member starts in an interval around the start of the primary one, and ends in one around its end. Kinds
of overlap and offsets bound both. Without `start_to_start`, all members start together: the standard leaves that
open.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf
from typing import Final, NamedTuple

from seoro.lang.plan import Behavior, Expression, Overlap, Parallel
from seoro.runtime.accept.compositions import CompositionChecker
from seoro.runtime.accept.findings import Rule, Undecided
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, UNKNOWN, End, title_of
from seoro.runtime.accept.history import Node
from seoro.runtime.accept.timing import Timing
from seoro.runtime.values.values import Range

_ANY: Final = (-inf, inf)
_ALLOWED: Final[Mapping[Overlap, tuple[tuple[float, float], tuple[float, float]]]] = {  # starts, ends
    Overlap.EQUAL: ((0.0, 0.0), (0.0, 0.0)),
    Overlap.START: ((0.0, 0.0), _ANY),
    Overlap.END: (_ANY, (0.0, 0.0)),
    Overlap.INITIAL: ((-inf, 0.0), _ANY),
    Overlap.FINAL: (_ANY, (0.0, inf)),
    Overlap.INSIDE: ((0.0, inf), (-inf, 0.0)),
    Overlap.FULL: ((-inf, 0.0), (0.0, inf)),
    Overlap.ANY: (_ANY, _ANY),
}


class _Fault(NamedTuple):
    """A member that violates the timing, with the time and the description of the fault."""

    t: float
    message: str
    member: int


class _Bounds(NamedTuple):
    """Bounds of the offsets of secondary members from the primary one [s]."""

    starts: tuple[float, float]
    ends: tuple[float, float]
    starts_together: bool


_UNDECIDED: Final = _Bounds(_ANY, _ANY, False)


@dataclass(eq=False)
class ParallelChecker(CompositionChecker):
    """Check of a `parallel`.

    Args:
        timing: Finds the times that constraints permit.
    """

    rule = Rule.PARALLEL
    plan: Parallel
    timing: Timing

    def __post_init__(self) -> None:
        super().__post_init__()
        self._bounds = _UNDECIDED
        with self.findings.undecided(self.rule, self.plan.span):
            self._bounds = self._find_bounds()
        self.may_end_secondaries = self._bounds is _UNDECIDED or self._bounds.ends[1] < inf

    # -------------------------------------------------------- bounds

    def _find_bounds(self) -> _Bounds:
        """Return the bounds from the arguments of the composition and the constraints on its offsets.

        Raises:
            Undecided: The trace lacks their values.
        """
        plan, frame = self.plan, self.frame
        after_starts, after_ends = (
            self.timing.offset(name, plan, frame) for name in ("start_to_start", "end_to_end")
        )
        overlap = self.timing.overlap(plan, frame)
        if overlap is None:  # offsets of starts alone mean any kind of overlap
            overlap = plan.overlap if after_starts is None or plan.is_overlap_given else Overlap.ANY
        starts, ends = _ALLOWED[overlap]
        starts = self._narrowed(starts, plan.start_to_start, after_starts)
        ends = self._narrowed(ends, plan.end_to_end, after_ends)
        if starts[0] > starts[1] or ends[0] > ends[1]:
            raise Undecided(f"an offset contradicts `overlap: {overlap.value}`")
        return _Bounds(starts, ends, plan.start_to_start is None and after_starts is None)

    def _narrowed(
        self, allowed: tuple[float, float], argument: Expression | None, constrained: Range | None
    ) -> tuple[float, float]:
        """Return the bounds of an offset that also meet its argument and its constraints."""
        given = [Range(*allowed)] if constrained is None else [Range(*allowed), constrained]
        if argument is not None:
            found = self.world.value(argument, self.frame.around.environment, self.frame.start.seq)
            if not isinstance(found, Range):
                raise Undecided(f"`{argument.span.text}` is not a range")
            given.append(found)
        return max(each.low for each in given), min(each.high for each in given)

    # -------------------------------------------------------- starts

    def _check_starts(self) -> None:
        """Check that members start together, or within the bounds of their offsets."""
        frame, members = self.frame, self.plan.members
        start, primary = frame.start.t, self.nodes.get(0)
        if self.nodes and min(node.start.t for node in self.nodes.values()) != start:
            self.violate("no member starts at its start", self.plan.span, *frame.records)
        for index, node in self.nodes.items():
            span = members[index].span
            if self._bounds.starts_together:
                if node.start.t != start:
                    message = f"`{node.name}` starts at {node.start.t:g} s; expected {start:g} s, with the others"
                    self.violate(message, span, frame.start.seq, node.start.seq)
            elif primary is not None and index > 0 and not self._is_offset(node.start.t, primary.start.t):
                message = f"`{node.name}` starts {_offset(node.start.t - primary.start.t)} the primary member"
                self.violate(message, span, primary.start.seq, node.start.seq)
        for member in self.missing:
            if self._frame_goes_on_after(self._latest_start(member)) and not self.may_be_overridden(member):
                self.violate(f"`{title_of(member)}` does not start", member.span, *frame.records)

    def _is_offset(self, secondary: float, primary: float) -> bool:
        low, high = self._bounds.starts
        return self._is_not_after(secondary, primary + high) and self._is_not_after(primary, secondary - low)

    def _is_not_after(self, t: float, limit: float) -> bool:
        """Whether a time is not after the event that is due at a limit."""
        return limit == inf or t <= limit + 1e-9 or t <= self.history.reached(limit)

    def _latest_start(self, member: Behavior) -> float:
        """Return the latest start of a member that has not started."""
        if self._bounds.starts_together or not self.nodes:
            return self.frame.start.t
        if member is not self.plan.members[0]:
            primary = self.nodes.get(0)
            return primary.start.t + self._bounds.starts[1] if primary is not None else inf
        return max(node.start.t for node in self.nodes.values()) - self._bounds.starts[0]

    def _frame_goes_on_after(self, due: float) -> bool:
        """Whether it continued after a time, neither ended nor failing in that instant."""
        if due == inf:
            return False
        reached = self.history.reached(due)
        failing = [node.end.t for node in self.nodes.values() if node.status == FAILED]
        return not (self.history.lasts(reached, self.frame.end.t) or any(t <= reached for t in failing))

    # -------------------------------------------------------- ends

    def end(self) -> End:
        """Check the members; return the end: after all of them, or with the first failure or timing fault."""
        if self._bounds is _UNDECIDED:
            return UNKNOWN
        self._check_starts()
        nodes, missing = self.nodes.values(), self.missing
        self.check_cancelled(nodes)
        failed = [node for node in nodes if node.status == FAILED]
        first = min(failed, key=lambda node: node.end, default=None)
        fault = min(self._faults(), default=None)
        if fault is not None and (first is None or fault.t < first.end.t):
            return self._end_of_fault(fault)
        if first is not None:
            self._check_others_ended(first)
            return End(FAILED, self._last_end(first.end.t), first.records)
        skipped = [UNKNOWN for member in missing if self.may_be_overridden(member)]
        ends = [*map(self.end_of, nodes), *skipped]
        if UNKNOWN in ends and self.frame.status == FAILED:
            return UNKNOWN  # an overridden member has ended, possibly against the timing
        if any(end.status is None for end in ends) or len(skipped) < len(missing):
            return End(None, max((node.end.t for node in nodes if node.status == CANCELLED), default=inf))
        if UNKNOWN in ends:
            return UNKNOWN
        return End(SUCCEEDED, max(node.end.t for node in nodes))

    def _end_of_fault(self, fault: _Fault) -> End:
        """Return the end by a timing fault; report if the composition did not fail then."""
        node, frame = self.nodes[fault.member], self.frame
        has_ended = self.history.lasts(fault.t, frame.end.t)
        if has_ended and frame.status == FAILED:
            return End(FAILED, self._last_end(fault.t), node.records)
        if not (has_ended and frame.status in frame.cuts):
            span = self.plan.members[fault.member].span
            self.violate(fault.message, span, *frame.records, *node.records)
        return UNKNOWN

    def _check_others_ended(self, first: Node) -> None:
        """Check that the others are cancelled when a member fails."""
        for index, node in self.nodes.items():
            if node.start.t > first.end.t:
                what, seq = "starts", node.start.seq
            elif node.end.t > first.end.t and not self.history.lasts(first.end.t, node.end.t):
                what, seq = "continues", node.end.seq
            else:
                continue
            message = f"`{node.name}` {what} after `{first.name}` has failed"
            self.findings.violate(Rule.OUTCOME, message, self.plan.members[index].span, first.end.seq, seq)

    def _last_end(self, t: float) -> float:
        """Return the time at which the last member finished its clean-up after `t`."""
        return max([t, *(node.end.t for node in self.nodes.values() if self.history.lasts(t, node.end.t))])

    def _faults(self) -> Iterator[_Fault]:
        primary = self.nodes.get(0)
        for index, node in self.nodes.items():
            if node.status == SUCCEEDED:
                yield from self._overlap_fault(index, node)
            if primary is not None and index > 0:
                yield from self._end_faults(index, node, primary)

    def _overlap_fault(self, index: int, node: Node) -> Iterator[_Fault]:
        """Check that there is an instant in which all members run."""
        late = [other for other in self.nodes.values() if other.start.t > node.end.t]
        is_missing = not all(map(self.may_be_overridden, self.missing))
        if late or (is_missing and self.frame.status == FAILED):
            what = f"`{late[0].name}` started" if late else "another member started"
            yield _Fault(node.end.t, f"`{node.name}` ended before {what}", index)

    def _end_faults(self, index: int, node: Node, primary: Node) -> Iterator[_Fault]:
        low, high = self._bounds.ends
        reached, end, ended = self.history.reached, node.end.t, primary.end.t
        name = node.name
        t, offset = max(end, ended), f"{_offset(end - ended)} the primary member"
        if node.status == SUCCEEDED and low > -inf:
            latest = reached(end + max(-low, 0.0))
            if ended > latest or self._was_cut(primary, latest):
                yield _Fault(latest, f"`{name}` ended before the primary member, which was still running", index)
            elif primary.status == SUCCEEDED and low > 0 and end < ended + low - 1e-9:
                yield _Fault(t, f"`{name}` ended {offset}", index)
        if primary.status == SUCCEEDED and high < inf:
            latest = reached(ended + max(high, 0.0))
            if end > latest and not (node.status == SUCCEEDED and self.history.lasts(latest, end)):
                still = f"{_offset(latest - ended)} the primary member"
                yield _Fault(latest, f"`{name}` was still running {still}", index)
            elif self._was_cut(node, latest):
                yield _Fault(latest, f"`{name}` was still running when it should have ended", index)
            elif node.status == SUCCEEDED and end > ended + high + 1e-9 and high < 0:
                yield _Fault(t, f"`{name}` ended {offset}", index)

    def _was_cut(self, node: Node, t: float) -> bool:
        """Whether a member still ran at a time, and was cancelled by the failure of the composition."""
        is_cut = node.status == CANCELLED and node.end.t >= t and self.history.lasts(t, node.end.t)
        return is_cut and self.frame.status == FAILED and not self.was_overridden(node)


def _offset(seconds: float) -> str:
    if abs(seconds) < 1e-9:
        return "together with"
    return f"{abs(seconds):g} s {'after' if seconds > 0 else 'before'}"
