"""`Overlap`: the policy of `parallel`: judges starts and ends of its members (7.3.13.2, 7.6.2.1.4).

- The first failing member fails the composition; the others are cancelled.
- Secondary members may have to end with the primary one, or some time after it. Remaining open-ended members are
  ended at that time; other remaining members are late, and fail the composition.
- Judgements are made when the instant has otherwise settled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import groupby
from math import inf

from seoro.lang.plan import Parallel
from seoro.runtime.behaviors.limits import is_open_ended
from seoro.runtime.behaviors.timing import Timing
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.execution.names import name_of
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.clock import TIME_DIGITS
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.verdict import CANCELLED, SUCCEEDED, Outcome, failure


class Overlap:
    """Judges the timing of the members of `parallel` relative to the primary one.

    Args:
        plan: The composition.
        timing: Times at which members start and end.
        explain: Adds an explanation to a failure when it happens.
        is_open_ended: Whether a member runs an open-ended behavior.
    """

    group: TaskGroup

    def __init__(
        self,
        plan: Parallel,
        timing: Timing,
        explain: Callable[[Outcome], Outcome],
        is_open_ended: Callable[[Task], bool],
    ) -> None:
        self.outcome = SUCCEEDED
        self._plan = plan
        self._timing = timing
        self._explain = explain
        self._is_open_ended = is_open_ended
        self._ended: dict[int, float] = {}  # end of each member [s]
        self._cut: set[int] = set()  # members ended at their due time; their clean-up may take time

    @property
    def failed(self) -> bool:
        """Whether the composition has failed."""
        return self.outcome.failed

    def starts(self, now: float) -> Iterator[tuple[float, Iterator[int]]]:
        """Yield the times at which members start [s], in order, with their indices.

        Args:
            now: Start of the composition [s].
        """
        offsets = self._timing.starts
        indices = sorted(range(len(self._plan.members)), key=offsets.__getitem__)
        for offset, together in groupby(indices, offsets.__getitem__):
            yield round(now + offset, TIME_DIGITS), together

    def child_ready(self, child: Task, resume: Callable[[], None]) -> None:
        """Resume the member: members of `parallel` have no guards."""
        resume()

    def child_ended(self, child: Task) -> None:
        """Judge the end of a member."""
        outcome: Outcome = CANCELLED if child.outcome is None else child.outcome
        if self.failed:
            return
        if outcome.failed:
            self._fail(outcome)
            return
        index = _index(child)
        self._ended[index] = self.group.now
        if len(self.group.children) < len(self._plan.members):
            self._later(0.0, partial(self._check_overlap, index))
        if index == 0:
            self._primary_ended()
        elif 0 in self._ended:
            if index not in self._cut:
                self._check_end(index)
        elif self._timing.ends.low > -inf:
            self._later(max(-self._timing.ends.low, 0.0), partial(self._check_early, index))

    def _primary_ended(self) -> None:
        for index in list(self._ended):
            if index != 0:
                self._check_end(index)
        high = self._timing.ends.high
        if high < inf:
            cuts = {cut for cut in self._timing.cuts if cut < inf}
            for cut in sorted(cuts | {max(high, 0.0)}):
                self._later(cut, partial(self._end_secondaries, cut))

    def _end_secondaries(self, offset: float) -> None:
        """End the open-ended members that are due; at the last offset, other members are late."""
        high = self._timing.ends.high
        for child in self.group.alive:
            index = _index(child)
            is_due = self._timing.cuts[index] <= offset <= high
            if is_due and self._is_open_ended(child):
                self._cut.add(index)
                self.group.end(child, SUCCEEDED)
            elif offset >= high:
                when = (
                    f"{offset:g} s after the primary member ended" if offset else "when the primary member ended"
                )
                self._fail_for(index, f"was still running {when}")
                return

    # -------------------------------------------------------- failures

    def _check_overlap(self, index: int) -> None:
        """Fail if a member ended before another one started."""
        started = {_index(child) for child in self.group.children}
        if len(started) < len(self._plan.members):
            waiting = next(other for other in range(len(self._plan.members)) if other not in started)
            self._fail_for(index, f"ended before `{self._name(waiting)}` started")

    def _check_early(self, index: int) -> None:
        """Fail if a secondary member ended, but the primary one, which should have ended before, still runs."""
        if 0 not in self._ended:
            self._fail_for(index, "ended before the primary member, which is still running")

    def _check_end(self, index: int) -> None:
        """Fail if a secondary member ended too early or too late relative to the primary one."""
        low, high = self._timing.ends.low, self._timing.ends.high
        offset = round(self._ended[index] - self._ended[0], TIME_DIGITS)
        if not round(low, TIME_DIGITS) <= offset <= round(high, TIME_DIGITS):
            relation = f"{abs(offset):g} s {'before' if offset < 0 else 'after'}" if offset else "together with"
            self._fail_for(index, f"ended {relation} the primary member; it should have {_due(low, high)}")

    def _fail_for(self, index: int, reason: str) -> None:
        self._fail(failure(f"`{self._name(index)}` {reason}", self._plan.members[index].span))

    def _fail(self, outcome: Outcome) -> None:
        if self.failed:
            return
        self.outcome = self._explain(outcome)
        for other in self.group.alive:
            self.group.cancel(other)
        self.group.interrupt()

    def _later(self, delay: float, check: Callable[[], None]) -> None:
        """Call a check after a delay [s], unless the composition has failed by then."""

        def act() -> None:
            if not self.failed:
                check()

        self.group.after(delay, act)

    def _name(self, index: int) -> str:
        return name_of(self._plan.members[index])


def overlap_in(context: ExecutionContext, plan: Parallel, timing: Timing) -> Overlap:
    """Return the policy of a composition in a context."""
    scope = context.task.scope
    assert isinstance(scope, CancelScope), "behaviors run in scopes"

    def explain(outcome: Outcome) -> Outcome:
        return context.explained(outcome, scope)

    def is_endless(child: Task) -> bool:
        return is_open_ended([child, *child.descendants()], scope, context.services.open_ended)

    return Overlap(plan, timing, explain, is_endless)


def _index(child: Task) -> int:
    """Return the index of a member, the last element of its position."""
    return child.path[-1]


def _due(low: float, high: float) -> str:
    """Describe when a secondary member should have ended."""
    if low == high:
        if low == 0:
            return "ended with it"
        return f"ended {abs(low):g} s {'before' if low < 0 else 'after'} it"
    bounds = (f"at least {low:g} s" if low > -inf else "", f"at most {high:g} s" if high < inf else "")
    return f"ended {' and '.join(filter(None, bounds))} after it"
