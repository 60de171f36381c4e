"""Actions: ordinary coroutines, their outcomes, and their clean-up."""

import asyncio
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager

import anyio
import pytest

from seoro import ActionContext, ActionFailed, UsageError, action
from seoro.embed.options import Options
from seoro.runtime.functions.actions import ActionFunction
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Prepare, RunText

DECLARATIONS = """
action work:
    name: string
    seconds: float = 0.0

action break_down
action give_up
action ignore_cancelling
"""


@action("work")
async def work(ctx: ActionContext, name: str, seconds: float) -> None:
    """Sleep on the run's clock, then wait for the outside world, also in the clean-up."""
    try:
        await ctx.sleep(seconds)
        await asyncio.sleep(0)
        ctx.log(f"{name} worked")
        await asyncio.sleep(0.02)
    except asyncio.CancelledError:
        await asyncio.sleep(0.01)
        ctx.log(f"{name} cleaned up")
        raise


@action("give_up")
async def give_up(ctx: ActionContext) -> None:
    raise ActionFailed("no use")


@action("break_down")
async def break_down(ctx: ActionContext) -> None:
    raise KeyError("bug")


@action("ignore_cancelling")
async def ignore_cancelling(ctx: ActionContext) -> None:
    while True:
        try:
            await asyncio.sleep(3600)
        except asyncio.CancelledError:
            ctx.log("ignored")


ACTIONS = (work, give_up, break_down, ignore_cancelling)


async def test_virtual_time_waits_for_real_work(run_text: RunText) -> None:
    ran = await run_text(
        DECLARATIONS
        + """
scenario main:
    do parallel:
        work("a", 1.0)
        serial:
            wait elapsed(1.5s)
            log("later")
""",
        actions=ACTIONS,
    )
    assert ran.logs == [(1.0, "a worked"), (1.5, "later")]
    assert ran.verdict.passed


async def test_a_failing_action_fails_with_its_reason_and_position(run_text: RunText) -> None:
    ran = await run_text(DECLARATIONS + "scenario main:\n    do give_up()\n", actions=ACTIONS)
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.reason == "`give_up` failed: no use"
    assert ran.verdict.span is not None
    assert ran.verdict.span.text.strip() == "give_up()"


async def test_an_exception_in_an_action_is_an_error_not_a_failure(run_text: RunText) -> None:
    ran = await run_text(
        DECLARATIONS
        + """
scenario main:
    do parallel:
        work("a", 5.0)
        break_down()
""",
        actions=ACTIONS,
    )
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.verdict.reason == "`break_down` raised KeyError: 'bug'"
    assert ran.logs == [(0.0, "a cleaned up")]


async def test_cancelled_actions_clean_up_in_reverse_order_of_starts(run_text: RunText) -> None:
    ran = await run_text(
        DECLARATIONS
        + """
scenario main:
    do parallel:
        work("a", 9.0)
        work("b", 9.0)
        serial:
            wait elapsed(1s)
            work("c", 9.0)
        serial:
            wait elapsed(2s)
            emit end
""",
        actions=ACTIONS,
    )
    assert ran.logs == [(2.0, "c cleaned up"), (2.0, "b cleaned up"), (2.0, "a cleaned up")]
    assert ran.verdict.passed
    assert len(ran.verdict.cancelled) == 6


async def test_an_action_that_does_not_end_is_reported_and_abandoned(prepare_text: Prepare) -> None:
    text = (
        DECLARATIONS
        + """
scenario main:
    do parallel:
        ignore_cancelling()
        emit end
"""
    )
    with anyio.fail_after(30.0):
        async with (
            prepare_text(text, Options(clock="virtual", grace=0.02), ACTIONS) as run,
            run.running(),
        ):
            verdict = await run.result()
    assert verdict.status is RunStatus.ERROR
    assert "clean-up of `ignore_cancelling` took longer than 0.02 s" in verdict.reason


async def test_an_action_on_the_real_clock_delays_no_other(prepare_text: Prepare) -> None:
    text = (
        DECLARATIONS
        + """
scenario main:
    do parallel:
        ignore_cancelling()
        serial:
            wait elapsed(0.01s)
            log("went on")
            emit fail
"""
    )
    with anyio.fail_after(30.0):
        async with prepare_text(text, Options(grace=0.02), ACTIONS) as run, run.running():
            messages = [record["message"] async for record in run.trace() if record["kind"] == "log"]
    assert messages[0] == "went on"


async def test_a_run_is_stopped_in_order_when_its_task_is_cancelled(prepare_text: Prepare) -> None:
    text = DECLARATIONS + 'scenario main:\n    do work("a", 9.0)\n'
    with anyio.CancelScope() as scope:
        async with prepare_text(text, Options(clock="real"), ACTIONS) as run, run.running():
            async for record in run.trace():
                if record.get("type") == "action":
                    scope.cancel()
    assert scope.cancelled_caught
    rest = [record async for record in run.trace()]
    assert [record["message"] for record in rest if record["kind"] == "log"] == ["a cleaned up"]
    assert rest[-1]["status"] == "cancelled"
    assert (await run.result()).status is RunStatus.CANCELLED


async def test_leaving_the_block_stops_the_run(prepare_text: Prepare) -> None:
    text = DECLARATIONS + 'scenario main:\n    do work("a", 9.0)\n'
    async with prepare_text(text, Options(clock="real"), ACTIONS) as run, run.running():
        await anyio.sleep(0.01)
    verdict = await run.result()
    assert verdict.status is RunStatus.CANCELLED


async def test_a_declaration_without_a_function_is_refused(prepare_text: Prepare) -> None:
    text = DECLARATIONS + 'scenario main:\n    do work("a")\n'
    with pytest.raises(UsageError, match="the action `work` has no implementation") as refused:
        async with prepare_text(text):
            pass
    span = refused.value.span
    assert span is not None
    assert span.text == 'work("a")', "where it is invoked"


@action("work")
async def work_with_timeouts(ctx: ActionContext, name: str, seconds: float) -> None:
    """Use nested cancel scopes, around real time and around the run's clock."""
    with anyio.move_on_after(0.005) as outside:
        await asyncio.sleep(3600)
    assert outside.cancelled_caught
    with anyio.CancelScope() as inside:
        if name == "a":
            inside.cancel()  # takes effect at the next wait
        await ctx.sleep(seconds)
    ctx.log(f"{name} {'gave up' if inside.cancelled_caught else 'slept'}")
    async with anyio.create_task_group() as group:
        group.start_soon(anyio.sleep, 0.005)
    await ctx.sleep(1.0)
    ctx.log(f"{name} is done")


@pytest.mark.parametrize("clock", ["virtual", "real"])
async def test_actions_may_use_cancel_scopes_and_task_groups(prepare_text: Prepare, clock: str) -> None:
    text = DECLARATIONS + 'scenario main:\n    do parallel:\n        work("a", 9.0)\n        work("b", 0.01)\n'
    options = Options(clock="virtual" if clock == "virtual" else "real")
    with anyio.fail_after(30):
        async with prepare_text(text, options, [work_with_timeouts]) as run, run.running():
            messages = [record["message"] async for record in run.trace() if record["kind"] == "log"]
            verdict = await run.result()
    assert verdict.passed, verdict.reason
    assert sorted(messages) == ["a gave up", "a is done", "b is done", "b slept"]


async def test_an_observer_that_raises_ends_the_run_as_an_error(prepare_text: Prepare) -> None:
    class Full:
        def record(self, record: dict[str, object]) -> None:
            raise OSError("no space left")

    text = "scenario main:\n    do wait elapsed(1h)\n"
    async with prepare_text(text, Options(observers=[Full()])) as run, run.running():
        verdict = await run.result()
    assert verdict.status is RunStatus.ERROR
    assert verdict.reason == "cannot write the trace: OSError: no space left"


@action("work")
async def work_with_a_broken_clean_up(ctx: ActionContext, name: str, seconds: float) -> None:
    try:
        await ctx.sleep(seconds)
    finally:
        raise ActionFailed(f"{name} could not clean up")


async def test_a_cancelled_action_stops_even_if_its_clean_up_swallows_the_cancellation(run_text: RunText) -> None:
    ran = await run_text(
        DECLARATIONS
        + """
scenario inner:
    do parallel:
        serial:
            work("a", 9.0)
            log("never")
        serial:
            wait elapsed(1s)
            emit end

scenario main:
    do serial:
        inner()
        wait elapsed(20s)
""",
        actions=[work_with_a_broken_clean_up],
    )
    assert ran.logs == [(1.0, "`work` failed: a could not clean up")]
    assert ran.verdict.passed
    assert ran.verdict.duration == 21.0


@action("work")
async def work_in_other_tasks(ctx: ActionContext, name: str, seconds: float) -> None:
    async with anyio.create_task_group() as group:
        group.start_soon(ctx.sleep, seconds)


async def test_waiting_on_the_context_in_another_task_is_distinguished(run_text: RunText) -> None:
    with anyio.fail_after(30.0):
        ran = await run_text(
            DECLARATIONS + 'scenario main:\n    do work("a", 1.0)\n', actions=[work_in_other_tasks]
        )
    assert ran.verdict.status is RunStatus.ERROR
    assert "only the action's own task" in ran.verdict.reason


@action("work")
async def work_that_fails_in_another_task(ctx: ActionContext, name: str, seconds: float) -> None:
    async def fail() -> None:
        raise ActionFailed(f"{name} fell")

    async with anyio.create_task_group() as group:
        group.start_soon(fail)


async def test_a_failure_in_a_task_of_an_action_is_a_failure(run_text: RunText) -> None:
    ran = await run_text(
        DECLARATIONS + 'scenario main:\n    do work("a", 1.0)\n', actions=[work_that_fails_in_another_task]
    )
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.reason == "`work` failed: a fell"


@action("work")
async def work_that_cancels_itself(ctx: ActionContext, name: str, seconds: float) -> None:
    task = asyncio.create_task(asyncio.sleep(3600))
    task.cancel()
    await task


@action("work")
async def work_that_exits(ctx: ActionContext, name: str, seconds: float) -> None:
    raise SystemExit(3)


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (work_that_cancels_itself, "`work` raised CancelledError, but was not cancelled"),
        (work_that_exits, "`work` raised SystemExit: 3"),
    ],
)
async def test_exceptions_of_actions_are_not_misinterpreted(
    function: ActionFunction, reason: str, run_text: RunText
) -> None:
    ran = await run_text(DECLARATIONS + 'scenario main:\n    do work("a", 1.0)\n', actions=[function])
    assert (ran.verdict.status, ran.verdict.reason) == (RunStatus.ERROR, reason)


async def test_the_verdict_lists_cancelled_actions_with_their_clean_up_times(prepare_text: Prepare) -> None:
    text = (
        DECLARATIONS
        + """
scenario main:
    do parallel:
        work("a", 9.0)
        ignore_cancelling()
        emit end
"""
    )
    async with prepare_text(text, Options(clock="virtual", grace=0.1), ACTIONS) as run, run.running():
        ended = [record async for record in run.trace()][-1]
        verdict = await run.result()
    by_path = {each.path: each for each in verdict.cancelled}
    slow, quick = by_path["main/parallel[0]/ignore_cancelling[1]"], by_path["main/parallel[0]/work[0]"]
    assert (slow.type, slow.overran) == ("action", True)
    assert 0.2 <= slow.clean_up < 2.0
    assert not quick.overran
    assert 0.01 <= quick.clean_up < 1.0
    assert quick.span.text.strip() == 'work("a", 9.0)'
    listed = ended["cancelled"]
    assert [each["path"] for each in listed] == [each.path for each in verdict.cancelled]
    listed_slow = listed[verdict.cancelled.index(slow)]
    assert listed_slow["overran"]
    assert listed_slow["clean_up"] in [n / 10 for n in range(2, 20)]


@action("work")
async def work_that_leaves_something_open(ctx: ActionContext, name: str, seconds: float) -> None:
    @asynccontextmanager
    async def door() -> AsyncGenerator[str]:
        ctx.log(f"{name} opens")
        yield name
        await asyncio.sleep(seconds)
        ctx.relay([f"{name} is closed"])

    kept = await ctx.keep(door())
    assert kept.value == name
    if name == "early":
        await kept.close()


async def test_kept_resources_are_closed_in_reverse_order_at_the_end_of_the_run(run_text: RunText) -> None:
    members = "".join(
        f"        {member}\n" for member in ('work("a")', 'work("early")', 'work("b")', "log('end')")
    )
    ran = await run_text(
        f"{DECLARATIONS}scenario main:\n    do serial:\n{members}", actions=[work_that_leaves_something_open]
    )
    assert [message for _, message in ran.logs] == [
        *("a opens", "early opens", "early is closed", "b opens", "end", "b is closed", "a is closed")
    ]
    assert [each.path for each in ran.verdict.cancelled] == ["main/serial[0]/work[2]", "main/serial[0]/work[0]"]


async def test_a_resource_that_closes_too_slowly_is_an_error(prepare_text: Prepare) -> None:
    text = DECLARATIONS + 'scenario main:\n    do work("a", 30.0)\n'
    options = Options(clock="virtual", grace=0.05)
    async with prepare_text(text, options, [work_that_leaves_something_open]) as run, run.running():
        verdict = await run.result()
    assert verdict.status is RunStatus.ERROR
    assert verdict.reason == "closing a resource of `work` took longer than 0.05 s"
    assert verdict.cancelled[0].overran


async def test_a_resource_that_never_opens_is_abandoned_with_its_action(prepare_text: Prepare) -> None:
    ends = []

    @action("work")
    async def work_that_waits_for_a_door(ctx: ActionContext, name: str, seconds: float) -> None:
        @asynccontextmanager
        async def door() -> AsyncGenerator[None]:
            try:
                await asyncio.get_running_loop().create_future()
                yield
            finally:
                ends.append(name)

        await ctx.keep(door())

    text = DECLARATIONS + 'scenario main:\n    do one_of:\n        work("a")\n        wait elapsed(50ms)\n'
    async with prepare_text(text, Options(clock="real"), [work_that_waits_for_a_door]) as run, run.running():
        verdict = await run.result()
    assert verdict.passed, verdict.reason
    assert ends == ["a"]


@action("work")
async def work_that_breaks_what_it_leaves_open(ctx: ActionContext, name: str, seconds: float) -> None:
    @asynccontextmanager
    async def door() -> AsyncGenerator[None]:
        if name == "at once":
            raise ActionFailed("no door")
        yield
        raise KeyError(name)

    await ctx.keep(door())


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("at once", "`work` failed: no door"),
        ("later", "a background resource of an action raised KeyError: 'later'"),
    ],
)
async def test_a_resource_that_fails_to_open_or_close_is_reported(
    name: str, reason: str, run_text: RunText
) -> None:
    text = f'scenario main:\n    do work("{name}")\n'
    ran = await run_text(DECLARATIONS + text, actions=[work_that_breaks_what_it_leaves_open])
    assert ran.verdict.reason == reason


@action("work")
async def work_that_waits_for_what_fails(ctx: ActionContext, name: str, seconds: float) -> None:
    async def fail() -> None:
        await asyncio.sleep(0.001)
        raise OSError("refused")

    try:
        await asyncio.create_task(fail())
    except OSError as error:
        ctx.log(f"{name}: {error}")
    await asyncio.create_task(fail())


async def test_an_awaited_report_may_be_a_failure(run_text: RunText) -> None:
    with anyio.fail_after(30.0):
        ran = await run_text(
            DECLARATIONS + 'scenario main:\n    do work("a")\n', actions=[work_that_waits_for_what_fails]
        )
    assert ran.logs == [(0.0, "a: refused")]
    assert ran.verdict.reason == "`work` raised OSError: refused"


@action("work")
async def work_on_after_a_scope(ctx: ActionContext, name: str, seconds: float) -> None:
    with anyio.move_on_after(0.001):
        await asyncio.sleep(3600)
    await asyncio.sleep(seconds)


async def test_a_cancel_scope_within_an_action_is_not_a_clean_up(prepare_text: Prepare) -> None:
    text = DECLARATIONS + 'scenario main:\n    do work("a", 0.1)\n'
    options = Options(clock="virtual", grace=0.02)
    async with prepare_text(text, options, [work_on_after_a_scope]) as run, run.running():
        verdict = await run.result()
    assert verdict.passed, verdict.reason
