"""Compositions and their members for tests of policies: without a scheduler, a run or a scenario."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from seoro.lang.plan import Behavior, Elapsed, Emit, OneOf, Overlap, Parallel, Phase, PhaseEvent, Serial, Wait
from seoro.lang.plan.expressions import Expression
from seoro.lang.source import SourceFile, Span
from seoro.runtime.kernel.task import Task, TaskScheduler
from seoro.runtime.verdict import Outcome

SPAN = Span(SourceFile("test.osc", "text"), 0, 4)


def emit(label: str) -> Behavior:
    return Emit(label, PhaseEvent(None, Phase.START, SPAN), (), SPAN)


def wait(label: str) -> Behavior:
    return Wait(label, Elapsed(cast(Expression, None), SPAN), SPAN)


def serial(*members: Behavior) -> Behavior:
    return Serial(None, members, None, (), (), SPAN)


def one_of(*members: Behavior) -> OneOf:
    return OneOf(None, members, None, (), (), SPAN)


def parallel(*members: Behavior) -> Parallel:
    return Parallel(None, members, None, (), (), SPAN, Overlap.ANY, False, None, None)


class Group:
    """Fake task group: the test ends its children; functions to call are collected."""

    def __init__(self) -> None:
        self.now = 0.0
        self.children: list[Task] = []
        self.cancelled: list[Task] = []
        self.ended: list[tuple[Task, Outcome]] = []
        self.later: list[tuple[float, Callable[[], None]]] = []
        self.choices: list[Callable[[], None]] = []
        self.is_interrupted = False

    def child(self, index: int) -> Task:
        """Start a member."""
        task = Task(cast(TaskScheduler, None), (index,), None, 0)
        self.children.append(task)
        return task

    @property
    def alive(self) -> list[Task]:
        return [child for child in self.children if child.alive]

    def cancel(self, child: Task, because_of: Task | None = None) -> None:
        self.cancelled.append(child)

    def end(self, child: Task, outcome: Outcome) -> None:
        self.ended.append((child, outcome))

    def after(self, delay: float, act: Callable[[], None]) -> None:
        self.later.append((self.now + delay, act))

    def choose(self, act: Callable[[], None]) -> None:
        self.choices.append(act)

    def interrupt(self) -> None:
        self.is_interrupted = True

    def settle(self) -> None:
        """Settle the instant: make choices, and call due functions."""
        choices, self.choices = self.choices, []
        for act in choices:
            act()
        due = [act for time, act in self.later if time <= self.now]
        self.later = [each for each in self.later if each[0] > self.now]
        for act in due:
            act()


def finish(child: Task, outcome: Outcome | None) -> Task:
    """End a member; None means that its task was cancelled."""
    child.alive, child.outcome = False, outcome
    return child
