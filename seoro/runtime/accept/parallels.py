"""`parallel` (7.6.2.1.4): timing of its members relative to the first, the primary one.

A secondary member starts in an interval around the start of the primary one, and ends in one around its end. Kinds
of overlap and offsets bound both. Without `start_to_start`, all members start together: the standard leaves that
open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import inf
from typing import Final, NamedTuple

from seoro.lang.plan import Behavior, Expression, Overlap, Parallel
from seoro.runtime.accept.compositions import Checking
from seoro.runtime.accept.findings import Rule, Undecided
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, UNKNOWN, End, Frame, title_of
from seoro.runtime.accept.history import Node
from seoro.runtime.accept.timing import Timing
from seoro.runtime.accept.world import World
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


class Bounds(NamedTuple):
    """Bounds of the offsets of secondary members from the primary one [s]."""

    starts: tuple[float, float]
    ends: tuple[float, float]
    starts_together: bool

    @property
    def may_end_secondaries(self) -> bool:
        """Whether open-ended secondary members are ended."""
        return self.ends[1] < inf


def bounds_of(plan: Parallel, frame: Frame, world: World, timing: Timing) -> Bounds:
    """Return the bounds from the arguments of a composition and the constraints on its offsets.

    Raises:
        Undecided: The trace lacks their values.
    """
    after_starts, after_ends = (timing.offset(name, plan, frame) for name in ("start_to_start", "end_to_end"))
    overlap = timing.overlap(plan, frame)
    if overlap is None:  # offsets of starts alone mean any kind of overlap
        overlap = plan.overlap if after_starts is None or plan.is_overlap_given else Overlap.ANY
    starts, ends = _ALLOWED[overlap]
    if plan.start_to_start is not None:
        starts = _within(_range(plan.start_to_start, frame, world), starts)
    if plan.end_to_end is not None:
        ends = _within(_range(plan.end_to_end, frame, world), ends)
    if after_starts is not None:
        starts = _within((after_starts.low, after_starts.high), starts)
    if after_ends is not None:
        ends = _within((after_ends.low, after_ends.high), ends)
    if starts[0] > starts[1] or ends[0] > ends[1]:
        raise Undecided(f"an offset contradicts `overlap: {overlap.value}`")
    return Bounds(starts, ends, plan.start_to_start is None and after_starts is None)


def _range(expression: Expression, frame: Frame, world: World) -> tuple[float, float]:
    found = world.value(expression, frame.around.environment, frame.start.seq)
    if not isinstance(found, Range):
        raise Undecided(f"`{expression.span.text}` is not a range")
    return found.low, found.high


def _within(given: tuple[float, float], allowed: tuple[float, float]) -> tuple[float, float]:
    return max(given[0], allowed[0]), min(given[1], allowed[1])


def end_of_parallel(
    plan: Parallel, frame: Frame, bounds: Bounds | None, checking: Checking
) -> tuple[list[tuple[Behavior, Node]], End]:
    """Check a `parallel`; return its members in the trace and its end.

    Args:
        plan: The composition.
        frame: Its frame.
        bounds: Bounds of its offsets; None if unknown.
        checking: Shared data of checks.
    """
    placed = checking.place_members(plan.members, frame.children, Rule.PARALLEL, plan.span)
    found = [(plan.members[index], node) for index, node in placed]
    if bounds is None:
        return found, UNKNOWN
    members = _Members(plan, frame, bounds, dict(placed), checking)
    members.check_starts()
    checking.check_cancelled(frame, (node for _, node in placed), Rule.PARALLEL, plan.span)
    return found, members.end()


class _Members:
    """Check of a `parallel`; for the arguments see `end_of_parallel`."""

    def __init__(
        self, plan: Parallel, frame: Frame, bounds: Bounds, nodes: dict[int, Node], checking: Checking
    ) -> None:
        self._plan = plan
        self._frame = frame
        self._bounds = bounds
        self._nodes = nodes
        self._checking = checking
        self._history = checking.history

    def check_starts(self) -> None:
        """Check that members start together, or within the bounds of their offsets."""
        findings, frame, members = self._checking.findings, self._frame, self._plan.members
        start, primary = frame.start.t, self._nodes.get(0)
        if self._nodes and min(node.start.t for node in self._nodes.values()) != start:
            findings.violate(Rule.PARALLEL, "no member starts at its start", self._plan.span, *frame.records)
        for index, node in self._nodes.items():
            span = members[index].span
            if self._bounds.starts_together:
                if node.start.t != start:
                    message = f"`{node.name}` starts at {node.start.t:g} s; expected {start:g} s, with the others"
                    findings.violate(Rule.PARALLEL, message, span, frame.start.seq, node.start.seq)
            elif primary is not None and index > 0 and not self._is_offset(node.start.t, primary.start.t):
                message = f"`{node.name}` starts {_offset(node.start.t - primary.start.t)} the primary member"
                findings.violate(Rule.PARALLEL, message, span, primary.start.seq, node.start.seq)
        for index in set(range(len(members))) - self._nodes.keys():
            due = self._latest_start(index)
            if self._frame_goes_on_after(due) and not self._checking.may_be_overridden(members[index]):
                message = f"`{title_of(members[index])}` does not start"
                findings.violate(Rule.PARALLEL, message, members[index].span, *frame.records)

    def _is_offset(self, secondary: float, primary: float) -> bool:
        low, high = self._bounds.starts
        return _not_after(secondary, primary + high, self._history.reached) and _not_after(
            primary, secondary - low, self._history.reached
        )

    def _latest_start(self, index: int) -> float:
        """Return the latest start of a member that has not started."""
        if self._bounds.starts_together or not self._nodes:
            return self._frame.start.t
        if index > 0:
            primary = self._nodes.get(0)
            return primary.start.t + self._bounds.starts[1] if primary is not None else inf
        return max(node.start.t for node in self._nodes.values()) - self._bounds.starts[0]

    def _frame_goes_on_after(self, due: float) -> bool:
        """Whether it continued after a time, neither ended nor failing in that instant."""
        if due == inf:
            return False
        reached = self._history.reached(due)
        failing = [node.end.t for node in self._nodes.values() if node.status == FAILED]
        return not (self._history.lasts(reached, self._frame.end.t) or any(t <= reached for t in failing))

    # -------------------------------------------------------- ends

    def end(self) -> End:
        """Return the end: after all members, or with the first failure or timing fault."""
        failed = [node for node in self._nodes.values() if node.status == FAILED]
        first = min(failed, key=lambda node: node.end, default=None)
        fault = min(self._faults(), default=None)
        if fault is not None and (first is None or fault.t < first.end.t):
            return self._end_of_fault(fault)
        if first is not None:
            self._check_others_ended(first)
            return End(FAILED, self._last_end(first.end.t), first.records)
        ends = [self._checking.end_of(node) for node in self._nodes.values()]
        missing = [member for index, member in enumerate(self._plan.members) if index not in self._nodes]
        skipped = [UNKNOWN for member in missing if self._checking.may_be_overridden(member)]
        ends += skipped
        if UNKNOWN in ends and self._frame.status == FAILED:
            return UNKNOWN  # an overridden member has ended, possibly against the timing
        if any(end.status is None for end in ends) or len(skipped) < len(missing):
            cancelled = [node.end.t for node in self._nodes.values() if node.status == CANCELLED]
            return End(None, max(cancelled, default=inf))
        if UNKNOWN in ends:
            return UNKNOWN
        return End(SUCCEEDED, max(node.end.t for node in self._nodes.values()))

    def _end_of_fault(self, fault: _Fault) -> End:
        """Return the end by a timing fault; report if the composition did not fail then."""
        node = self._nodes[fault.member]
        frame = self._frame
        has_failed = frame.status == FAILED and self._history.lasts(fault.t, frame.end.t)
        was_cut = frame.status in frame.cuts and self._history.lasts(fault.t, frame.end.t)
        if not (has_failed or was_cut):
            span = self._plan.members[fault.member].span
            self._checking.findings.violate(Rule.PARALLEL, fault.message, span, *frame.records, *node.records)
            return UNKNOWN
        return End(FAILED, self._last_end(fault.t), node.records) if has_failed else UNKNOWN

    def _check_others_ended(self, first: Node) -> None:
        """Check that the others are cancelled when a member fails."""
        for index, node in self._nodes.items():
            span = self._plan.members[index].span
            if node.start.t > first.end.t:
                message = f"`{node.name}` starts after `{first.name}` has failed"
                self._checking.findings.violate(Rule.OUTCOME, message, span, first.end.seq, node.start.seq)
            elif node.end.t > first.end.t and not self._history.lasts(first.end.t, node.end.t):
                message = f"`{node.name}` continues after `{first.name}` has failed"
                self._checking.findings.violate(Rule.OUTCOME, message, span, first.end.seq, node.end.seq)

    def _last_end(self, t: float) -> float:
        """Return the time at which the last member finished its clean-up after `t`."""
        ends = [node.end.t for node in self._nodes.values() if self._history.lasts(t, node.end.t)]
        return max([t, *ends])

    def _faults(self) -> Iterator[_Fault]:
        primary = self._nodes.get(0)
        for index, node in self._nodes.items():
            if node.status == SUCCEEDED:
                yield from self._overlap_fault(index, node)
        if primary is None:
            return
        for index, node in self._nodes.items():
            if index > 0:
                yield from self._end_faults(index, node, primary)

    def _overlap_fault(self, index: int, node: Node) -> Iterator[_Fault]:
        """Check that there is an instant in which all members run."""
        late = [other for other in self._nodes.values() if other.start.t > node.end.t]
        missing = (member for place, member in enumerate(self._plan.members) if place not in self._nodes)
        is_missing = any(not self._checking.may_be_overridden(member) for member in missing)
        if late or (is_missing and self._frame.status == FAILED):
            what = f"`{late[0].name}` started" if late else "another member started"
            yield _Fault(node.end.t, f"`{node.name}` ended before {what}", index)

    def _end_faults(self, index: int, node: Node, primary: Node) -> Iterator[_Fault]:
        low, high = self._bounds.ends
        reached, end = self._history.reached, node.end.t
        name = node.name
        if node.status == SUCCEEDED and low > -inf:
            latest = reached(end + max(-low, 0.0))
            if primary.end.t > latest or self._was_cut(primary, latest):
                yield _Fault(latest, f"`{name}` ended before the primary member, which was still running", index)
            elif primary.status == SUCCEEDED and low > 0 and end < primary.end.t + low - 1e-9:
                t = max(end, primary.end.t)
                yield _Fault(t, f"`{name}` ended {_offset(end - primary.end.t)} the primary member", index)
        if primary.status == SUCCEEDED and high < inf:
            latest = reached(primary.end.t + max(high, 0.0))
            if end > latest and not (node.status == SUCCEEDED and self._history.lasts(latest, end)):
                yield _Fault(
                    latest,
                    f"`{name}` was still running {_offset(latest - primary.end.t)} the primary member",
                    index,
                )
            elif self._was_cut(node, latest):
                yield _Fault(latest, f"`{name}` was still running when it should have ended", index)
            elif node.status == SUCCEEDED and end > primary.end.t + high + 1e-9 and high < 0:
                t = max(end, primary.end.t)
                yield _Fault(t, f"`{name}` ended {_offset(end - primary.end.t)} the primary member", index)

    def _was_cut(self, node: Node, t: float) -> bool:
        """Whether a member still ran at a time, and was cancelled by the failure of the composition."""
        is_cut = node.status == CANCELLED and node.end.t >= t and self._history.lasts(t, node.end.t)
        return is_cut and self._frame.status == FAILED and not self._checking.was_overridden(node)


def _not_after(t: float, limit: float, reached: Callable[[float], float]) -> bool:
    """Whether a time is not after the event that is due at a limit."""
    return limit == inf or t <= limit + 1e-9 or t <= reached(limit)


def _offset(seconds: float) -> str:
    if abs(seconds) < 1e-9:
        return "together with"
    return f"{abs(seconds):g} s {'after' if seconds > 0 else 'before'}"
