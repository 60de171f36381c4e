"""`Choice`, the policy of `one_of`, without a scheduler."""

from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import cast

from seoro.lang.plan import Behavior
from seoro.runtime.behaviors.choice import Choice
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.verdict import CANCELLED, SUCCEEDED, Outcome, failure
from tests.runtime.behaviors.groups import SPAN, Group, emit, finish, one_of, serial, wait

FAILED = failure("a reason", SPAN)


class Case:
    """A choice whose members are controlled by the test."""

    def __init__(self, *members: Behavior, seed: int = 0) -> None:
        self.group = Group()
        self.choice = Choice(one_of(*members), Random(seed))
        self.choice.group = cast(TaskGroup, self.group)
        self.resumed: list[Task] = []

    def guarded(self, index: int) -> Task:
        """Start a guarded member."""
        child = self.group.child(index)
        child.guard = self.choice.child_ready
        return child

    def ready(self, child: Task) -> None:
        """Report the end of the guard of a member."""
        child.guard = None
        self.choice.child_ready(child, lambda: self.resumed.append(child))

    def end(self, child: Task, outcome: Outcome | None = SUCCEEDED) -> None:
        self.choice.child_ended(finish(child, outcome))


def test_members_that_begin_with_a_wait_are_guarded() -> None:
    case = Case(emit("a"), wait("b"), serial(serial(wait("c")), emit("d")), serial(emit("e"), wait("f")), serial())
    assert [(index, path) for index, path, _ in case.choice.guarded((7,))] == [(1, (7, 1)), (2, (7, 2))]
    assert sorted(index for index in iter(case.choice.draw, None) if index is not None) == [0, 3, 4]


def test_unguarded_members_are_drawn_in_an_order_that_the_seed_decides() -> None:
    orders = set()
    for seed in range(20):
        choices = [Case(emit("a"), emit("b"), emit("c"), seed=seed).choice for _ in range(2)]
        first, second = (tuple(iter(choice.draw, None)) for choice in choices)
        assert first == second
        orders.add(first)
    assert len(orders) > 3


def test_an_invoked_member_that_ends_decides() -> None:
    case = Case(emit("a"), wait("b"))
    guarded, invoked = case.guarded(1), case.group.child(0)
    case.end(invoked)
    assert case.group.cancelled == [guarded]
    case.end(guarded, None)
    assert (case.choice.outcome, case.choice.draw()) == (SUCCEEDED, None)


def test_the_first_in_source_order_of_simultaneous_guards_wins() -> None:
    case = Case(wait("a"), wait("b"), emit("c"))
    first, second, invoked = case.guarded(0), case.guarded(1), case.group.child(2)
    case.ready(second)
    case.ready(first)
    assert case.resumed == []
    case.group.settle()
    assert case.resumed == [first]
    assert case.group.cancelled == [second, invoked]


def test_an_invoked_member_that_ends_in_the_instant_of_a_guard_has_ended_first() -> None:
    case = Case(wait("a"), emit("b"))
    guarded, invoked = case.guarded(0), case.group.child(1)
    case.ready(guarded)
    case.end(invoked)
    case.group.settle()
    assert case.resumed == []
    assert case.group.cancelled == [guarded]


def test_a_guarded_member_that_was_cancelled_meanwhile_is_not_chosen() -> None:
    case = Case(wait("a"), wait("b"))
    first, second = case.guarded(0), case.guarded(1)
    case.ready(first)
    case.ready(second)
    first.cancelled_depth = 0
    case.group.settle()
    assert case.resumed == [second]


def test_the_outcome_is_that_of_the_chosen_member() -> None:
    case = Case(wait("a"), wait("b"))
    first, second = case.guarded(0), case.guarded(1)
    case.ready(first)
    case.group.settle()
    case.end(second, None)
    case.end(first, FAILED)
    assert case.choice.outcome == FAILED


def test_guards_stay_armed_when_the_invoked_member_fails() -> None:
    case = Case(emit("a"), wait("b"))
    guarded, invoked = case.guarded(1), case.group.child(0)
    case.end(invoked, FAILED)
    assert case.group.cancelled == []
    case.ready(guarded)
    case.group.settle()
    case.end(guarded)
    assert case.choice.outcome == SUCCEEDED


def test_the_next_member_is_drawn_after_a_failure_until_all_have_failed() -> None:
    case = Case(emit("a"), emit("b"))
    for _ in range(2):
        index = case.choice.draw()
        assert index is not None
        case.end(case.group.child(index), FAILED)
    assert case.choice.draw() is None
    assert case.choice.outcome.failed
    assert case.choice.outcome.reason == "every member has failed; the last failure: a reason"


def test_a_cancelled_invoked_member_decides() -> None:
    case = Case(emit("a"), emit("b"))
    case.end(case.group.child(0), CANCELLED)
    assert (case.choice.outcome, case.choice.draw()) == (CANCELLED, None)


def test_a_member_prevented_from_starting_is_not_chosen() -> None:
    case = Case(emit("a"), emit("b"))
    case.end(case.group.child(0), replace(CANCELLED, has_begun=False))
    assert case.choice.draw() is not None


def test_a_member_that_ended_before_its_guard_is_not_chosen() -> None:
    case = Case(wait("a"), emit("b"))
    guarded, invoked = case.guarded(0), case.group.child(1)
    case.end(guarded, CANCELLED)
    assert case.group.cancelled == []
    case.end(invoked)
    assert case.choice.outcome == SUCCEEDED
