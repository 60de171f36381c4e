"""`Settling` alone: choices and deadlines at the end of an instant, and their order."""

from __future__ import annotations

from functools import partial

import pytest

from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.clock import VirtualClock
from seoro.runtime.kernel.delta import Effects
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.settling import Settling
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.timers import Deadline


@pytest.fixture
async def task() -> Task:
    return Task(Scheduler(VirtualClock()), (0,), None, 0)


def settle(settling: Settling, *, with_deadlines: bool = True) -> list[bool]:
    """Let the next entries act, with their effects; return whether any did."""
    effects: Effects = []
    found = settling.act(effects, with_deadlines=with_deadlines)
    for _, act, _ in effects:
        act()
    return [found]


async def test_choices_then_deadlines_then_the_rest_act_each_in_a_turn_of_their_own(task: Task) -> None:
    log: list[str] = []
    settling, scope = Settling(), CancelScope(task)
    settling.rest.append(partial(log.append, "rest"))
    settling.deadlines.append(Deadline(scope, partial(log.append, "deadline")))
    settling.choices.append(Deadline(scope, partial(log.append, "choice")))
    for expected in (["choice"], ["choice", "deadline"], ["choice", "deadline", "rest"]):
        assert settle(settling) == [True]
        assert log == expected
    assert settle(settling) == [False]


async def test_deadlines_are_held_back_while_something_may_end_in_time(task: Task) -> None:
    log: list[str] = []
    settling = Settling()
    settling.deadlines.append(Deadline(CancelScope(task), partial(log.append, "deadline")))
    assert settle(settling, with_deadlines=False) == [False]
    assert settle(settling) == [True]
    assert log == ["deadline"]


async def test_inner_deadlines_act_first(task: Task) -> None:
    log: list[str] = []
    settling = Settling()
    with CancelScope(task) as outer, CancelScope(task) as inner:
        settling.deadlines.append(Deadline(outer, partial(log.append, "outer")))
        settling.deadlines.append(Deadline(inner, partial(log.append, "inner")))
        assert settle(settling) == [True]
        assert log == ["inner"]
        assert settle(settling) == [True]
    assert log == ["inner", "outer"]


async def test_independent_deadlines_act_together(task: Task) -> None:
    log: list[str] = []
    settling = Settling()
    for name in ("a", "b"):
        settling.deadlines.append(Deadline(CancelScope(task), partial(log.append, name)))
    assert settle(settling) == [True]
    assert log == ["a", "b"]


async def test_finished_deadlines_do_not_act_and_deadlines_finish_by_acting(task: Task) -> None:
    log: list[str] = []
    settling = Settling()
    over, acting = (Deadline(CancelScope(task), partial(log.append, name)) for name in ("over", "acting"))
    over.over = True
    settling.deadlines.append(over)
    settling.deadlines.append(acting)
    assert settle(settling) == [True]
    assert (log, acting.over) == (["acting"], True)
