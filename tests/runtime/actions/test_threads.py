"""Blocking actions: each runs in a thread, learns of its cancellation, and is abandoned if it does not end."""

import asyncio
import threading
import time

import anyio
import pytest

from seoro import ActionFailed, ThreadContext, Variable, action
from seoro.embed.options import Options
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Prepare, RunText

DECLARATIONS = """
action work:
    name: string
    seconds: float = 0.0

action count:
    variable: string
"""


@action("work", thread=True)
def work(ctx: ThreadContext, name: str, seconds: float) -> None:
    """Sleep on the run's clock, compute, and clean up."""
    try:
        ctx.sleep(seconds)
        time.sleep(0.01)
        ctx.log(f"{name} worked")
    finally:
        if ctx.cancelled:
            ctx.log(f"{name} cleaned up")


async def test_virtual_time_advances_while_a_thread_sleeps_only(run_text: RunText) -> None:
    text = """
scenario main:
    do parallel:
        work("a", 1.0)
        work("b", 2.0)
        serial:
            wait elapsed(1.5s)
            log("between")
"""
    before = threading.active_count()
    ran = await run_text(DECLARATIONS + text, actions=[work])
    assert ran.logs == [(1.0, "a worked"), (1.5, "between"), (2.0, "b worked")]
    assert ran.verdict.passed
    assert threading.active_count() == before


async def test_the_event_loop_continues_while_a_thread_blocks(prepare_text: Prepare) -> None:
    released = threading.Event()

    @action("work", thread=True)
    def block(ctx: ThreadContext, name: str, seconds: float) -> None:
        assert released.wait(30.0)

    text = DECLARATIONS + 'scenario main:\n    do work("a")\n'
    async with prepare_text(text, Options(clock="real"), [block]) as run, run.running():
        await anyio.sleep(0.01)
        released.set()
        assert (await run.result()).passed


async def test_now_is_the_time_of_the_runs_clock(run_text: RunText) -> None:
    times: list[float] = []

    @action("work", thread=True)
    def look(ctx: ThreadContext, name: str, seconds: float) -> None:
        times.append(ctx.now)
        ctx.sleep(seconds)
        times.append(ctx.now)

    await run_text(DECLARATIONS + 'scenario main:\n    do work("a", 2.5)\n', actions=[look])
    assert times == [0.0, 2.5]


async def test_a_thread_changes_variables(run_text: RunText) -> None:
    @action("count", thread=True)
    def count(ctx: ThreadContext, variable: Variable[float]) -> None:
        ctx.update(variable, lambda value: value + 41)

    text = "scenario main:\n    var n: int = 1\n    do serial:\n        count(n)\n        log(n)\n"
    ran = await run_text(DECLARATIONS + text, actions=[count])
    assert ran.logs == [(0.0, "42")]


@pytest.mark.parametrize(
    ("raised", "status", "reason"),
    [
        (ActionFailed("no use"), RunStatus.FAILED, "`work` failed: no use"),
        (KeyError("bug"), RunStatus.ERROR, "`work` raised KeyError: 'bug'"),
        (SystemExit(3), RunStatus.ERROR, "`work` raised SystemExit: 3"),
        (asyncio.CancelledError(), RunStatus.ERROR, "`work` raised CancelledError, but was not cancelled"),
    ],
)
async def test_an_exception_of_a_thread_is_raised_by_its_action(
    raised: BaseException, status: RunStatus, reason: str, run_text: RunText
) -> None:
    @action("work", thread=True)
    def break_down(ctx: ThreadContext, name: str, seconds: float) -> None:
        raise raised

    ran = await run_text(DECLARATIONS + 'scenario main:\n    do work("a")\n', actions=[break_down])
    assert (ran.verdict.status, ran.verdict.reason) == (status, reason)


async def test_a_sleeping_thread_is_woken_when_it_is_cancelled(run_text: RunText) -> None:
    text = """
scenario main:
    do parallel:
        work("a", 9.0)
        work("b", 9.0)
        serial:
            wait elapsed(1s)
            emit end
"""
    before = threading.active_count()
    ran = await run_text(DECLARATIONS + text, actions=[work])
    assert ran.logs == [(1.0, "b cleaned up"), (1.0, "a cleaned up")]
    assert ran.verdict.passed
    assert threading.active_count() == before


async def test_a_computing_thread_can_query_its_cancellation(prepare_text: Prepare) -> None:
    looked: list[str] = []

    @action("work", thread=True)
    def compute(ctx: ThreadContext, name: str, seconds: float) -> None:
        while not ctx.cancelled:
            time.sleep(0.001)
        for ask in (ctx.check_cancelled, lambda: ctx.sleep(0.0)):
            with pytest.raises(asyncio.CancelledError):
                ask()
        looked.append(name)
        ctx.check_cancelled()

    text = DECLARATIONS + 'scenario main:\n    do work("a")\n'
    async with prepare_text(text, Options(clock="real"), [compute]) as run, run.running():
        await anyio.sleep(0.02)
        run.stop("enough")
        verdict = await run.result()
    assert looked == ["a"]
    assert verdict.status is RunStatus.CANCELLED


@pytest.mark.parametrize("clock", ["real", "virtual"])
async def test_a_thread_that_does_not_end_is_reported_and_abandoned(clock: str, prepare_text: Prepare) -> None:
    released = threading.Event()
    refused: list[bool] = []
    over = threading.Event()

    @action("work", thread=True)
    def hang(ctx: ThreadContext, name: str, seconds: float) -> None:
        released.wait(30.0)
        ctx.log("lost log")
        try:
            ctx.sleep(1.0)
        except asyncio.CancelledError:
            refused.append(ctx.cancelled)
        over.set()

    text = DECLARATIONS + 'scenario main:\n    do parallel:\n        work("a")\n        emit end\n'
    options = Options(clock="real" if clock == "real" else "virtual", grace=0.02)
    with anyio.fail_after(30.0):
        async with prepare_text(text, options, [hang]) as run, run.running():
            verdict = await run.result()
    assert verdict.status is RunStatus.ERROR
    assert "the thread of `work` has not ended 0.02 s after it was cancelled; it is at " in verdict.reason
    assert "test_threads.py:" in verdict.reason
    assert verdict.span is not None
    assert verdict.span.text.strip() == 'work("a")'
    released.set()
    assert over.wait(30.0)
    assert refused == [True]
