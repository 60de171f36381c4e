"""`Overlap`, the policy of `parallel`, without a scheduler."""

from __future__ import annotations

from math import inf
from typing import cast

from seoro.runtime.behaviors.overlap import Overlap
from seoro.runtime.behaviors.timing import Timing
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.values.values import Range
from seoro.runtime.verdict import CANCELLED, SUCCEEDED, Outcome, failure
from tests.runtime.behaviors.groups import SPAN, Group, emit, finish, parallel

ANY = Range(-inf, inf)
FAILED = failure("a reason", SPAN)


class Case:
    """A composition whose members are controlled by the test."""

    def __init__(
        self,
        starts: tuple[float, ...] = (0.0, 0.0),
        ends: Range = ANY,
        cuts: tuple[float, ...] = (inf, inf),
        open_ended: frozenset[int] = frozenset(),
    ) -> None:
        plan = parallel(*(emit(name) for name in "abc"[: len(starts)]))
        self.group = Group()
        self.policy = Overlap(plan, Timing(starts, ends, cuts), lambda outcome: outcome, self._is_open_ended)
        self.policy.group = cast(TaskGroup, self.group)
        self._open_ended = open_ended

    def _is_open_ended(self, child: Task) -> bool:
        return child.path[-1] in self._open_ended

    def start(self, *indices: int) -> list[Task]:
        return [self.group.child(index) for index in indices]

    def end(self, child: Task, time: float, outcome: Outcome | None = SUCCEEDED) -> None:
        self.at(time)
        self.policy.child_ended(finish(child, outcome))

    def at(self, time: float) -> None:
        """Settle all instants before a time, and start that instant."""
        for due in sorted({due for due, _ in self.group.later if due < time}):
            self.group.now = due
            self.group.settle()
        if self.group.now < time:
            self.group.settle()
        self.group.now = time

    def settle(self) -> str:
        """Settle the instant; return the reason of the failure."""
        self.group.settle()
        return self.policy.outcome.reason


def test_members_start_at_their_times_in_source_order() -> None:
    policy = Case(starts=(1.0, 0.0, 1.0)).policy
    assert [(time, list(indices)) for time, indices in policy.starts(10.0)] == [(10.0, [1]), (11.0, [0, 2])]


def test_a_parallel_succeeds_when_all_members_have() -> None:
    case = Case()
    for child in case.start(0, 1):
        case.end(child, 1.0)
    assert case.settle() == ""
    assert case.policy.outcome == SUCCEEDED


def test_a_member_that_was_cancelled_has_not_failed() -> None:
    case = Case()
    first, second = case.start(0, 1)
    case.end(first, 1.0, None)
    case.end(second, 1.0, CANCELLED)
    assert case.settle() == ""


def test_the_first_failing_member_fails_the_parallel_and_cancels_the_others() -> None:
    case = Case(starts=(0.0, 0.0, 5.0))
    first, second = case.start(0, 1)
    case.end(first, 1.0, FAILED)
    assert case.policy.failed
    assert case.group.cancelled == [second]
    assert case.group.is_interrupted  # the third does not start
    case.end(second, 1.0, failure("another reason", SPAN))
    assert case.settle() == "a reason"


def test_a_parallel_resumes_guarded_members_at_once() -> None:
    resumed: list[str] = []
    case = Case()
    case.policy.child_ready(case.start(0)[0], lambda: resumed.append("at once"))
    assert resumed == ["at once"]


def test_a_parallel_fails_when_a_member_ends_before_another_starts() -> None:
    case = Case(starts=(0.0, 2.0))
    case.end(case.start(0)[0], 1.0)
    assert case.settle() == "`a` ended before `b` started"


def test_a_member_may_start_in_the_instant_in_which_another_ends() -> None:
    case = Case(starts=(0.0, 2.0))
    case.end(case.start(0)[0], 2.0)
    case.start(1)
    assert case.settle() == ""


def test_a_secondary_member_that_is_open_ended_is_ended_with_the_primary_one() -> None:
    case = Case(ends=Range(0.0, 0.0), cuts=(inf, 0.0), open_ended=frozenset({1}))
    first, second = case.start(0, 1)
    case.end(first, 1.0)
    assert case.settle() == ""
    assert case.group.ended == [(second, SUCCEEDED)]
    case.end(second, 3.0)  # its clean-up takes time
    assert case.settle() == ""


def test_a_secondary_member_with_its_own_end_is_late() -> None:
    case = Case(ends=Range(0.0, 0.0), cuts=(inf, 0.0))
    first, second = case.start(0, 1)
    case.end(first, 1.0)
    assert case.settle() == "`b` was still running when the primary member ended"
    assert case.group.cancelled == [second]


def test_a_secondary_member_that_ends_in_the_same_instant_is_in_time() -> None:
    case = Case(ends=Range(0.0, 0.0), cuts=(inf, 0.0))
    for child in case.start(0, 1):
        case.end(child, 1.0)
    assert case.settle() == ""


def test_a_secondary_member_may_end_a_while_after_the_primary_one() -> None:
    case = Case(ends=Range(0.0, 2.0), cuts=(inf, inf))
    first, second = case.start(0, 1)
    case.end(first, 1.0)
    case.end(second, 3.0)
    assert case.settle() == ""


def test_a_secondary_member_that_runs_longer_fails_at_the_last_moment() -> None:
    case = Case(ends=Range(0.0, 2.0), cuts=(inf, inf))
    first, _ = case.start(0, 1)
    case.end(first, 1.0)
    case.at(3.0)
    assert not case.policy.failed
    assert case.settle() == "`b` was still running 2 s after the primary member ended"


def test_a_secondary_member_that_ends_too_early_fails_at_once() -> None:
    case = Case(ends=Range(0.0, inf))
    _, second = case.start(0, 1)
    case.end(second, 1.0)
    assert case.settle() == "`b` ended before the primary member, which is still running"


def test_the_primary_member_may_still_end_in_that_instant() -> None:
    case = Case(ends=Range(0.0, inf))
    first, second = case.start(0, 1)
    case.end(second, 1.0)
    case.end(first, 1.0)
    assert case.settle() == ""


def test_a_secondary_member_may_end_a_while_before_the_primary_one() -> None:
    case = Case(ends=Range(-1.0, 0.0))
    first, second = case.start(0, 1)
    case.end(second, 1.0)
    case.end(first, 2.0)
    assert case.settle() == ""


def test_a_primary_member_that_runs_too_long_fails_the_parallel() -> None:
    case = Case(ends=Range(-1.0, 0.0))
    _, second = case.start(0, 1)
    case.end(second, 1.0)
    case.at(2.0)
    assert case.settle() == "`b` ended before the primary member, which is still running"


def test_a_secondary_member_that_ends_too_late_fails_the_parallel() -> None:
    case = Case(ends=Range(-2.0, -1.0))
    first, second = case.start(0, 1)
    case.end(second, 1.0)
    case.end(first, 1.5)
    reason = (
        "`b` ended 0.5 s before the primary member; it should have ended at least -2 s and at most -1 s after it"
    )
    assert case.settle() == reason
