"""A run is a guest: it touches nothing of the program, and leaves nothing behind however it ends."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

import anyio
import pytest

import seoro
from tests.embedding.conftest import as_it_was, holdings, state_of_the_program

ENDLESS = "import osc.types\nscenario main:\n    do wait elapsed(1h)\n"
MAX_STEPS = 2000  # of the loop, for a run that takes some hundred


async def watch(scenario: seoro.Scenario) -> seoro.Verdict:
    async with seoro.start(scenario, seed=3, clock="virtual") as run:
        async for _ in run.trace():
            pass
        return await run.result()


@pytest.mark.more
async def test_a_run_does_not_change_global_state(scenario: seoro.Scenario) -> None:
    async with as_it_was():
        before = state_of_the_program()
        async with seoro.start(scenario, seed=3, clock="virtual") as run:
            async for _ in run.trace():
                assert state_of_the_program() == before
        assert (await run.result()).passed


async def cancel_after(
    steps: int, scenario: seoro.Scenario, again_after: int | None = None
) -> asyncio.Task[seoro.Verdict]:
    """Cancel a program after some turns of the loop, perhaps once more after others; returns its ended task."""
    task = asyncio.create_task(watch(scenario))
    for _ in range(steps):
        await asyncio.sleep(0)
    task.cancel()
    if again_after is not None:
        for _ in range(again_after):
            await asyncio.sleep(0)
        task.cancel()
    with suppress(asyncio.CancelledError):
        await task
    return task


async def test_a_cancellation_at_any_step_of_the_loop_leaves_nothing(scenario: seoro.Scenario) -> None:
    """The program's task is cancelled after 0, 1, 2, ... turns of the loop, until the run is over before."""
    async with as_it_was():
        held = holdings()
        for steps in range(MAX_STEPS):
            task = await cancel_after(steps, scenario)
            left = holdings() - held
            assert not left, f"after {steps} steps"
            if not task.cancelled():
                break
        else:
            pytest.fail("the run never came to its end")
    assert steps > 50


async def test_two_cancellations_leave_nothing(scenario: seoro.Scenario) -> None:
    async with as_it_was():
        held = holdings()
        for steps in range(60):
            await cancel_after(steps, scenario, again_after=steps % 4)
            left = holdings() - held
            assert not left, f"after {steps} steps"


async def test_a_cancelled_run_has_a_verdict_and_a_whole_trace(load: Callable[[str], seoro.Scenario]) -> None:
    runs: list[seoro.Run] = []

    async def program() -> None:
        async with seoro.start(load(ENDLESS)) as run:
            runs.append(run)
            await asyncio.sleep(3600)

    task = asyncio.create_task(program())
    await asyncio.sleep(0.01)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    [run] = runs
    verdict = await run.result()
    assert verdict.status is seoro.RunStatus.CANCELLED
    assert [record["kind"] async for record in run.trace()][-1] == "run.end"


@asynccontextmanager
async def anyio_limit(seconds: float) -> AsyncIterator[None]:
    with anyio.fail_after(seconds):
        yield


@pytest.mark.parametrize("limit", [asyncio.timeout, anyio_limit])
async def test_a_time_limit_of_the_program_is_kept(
    load: Callable[[str], seoro.Scenario], limit: Callable[[float], asyncio.Timeout]
) -> None:
    with pytest.raises(TimeoutError):
        async with limit(0.3), seoro.start(load(ENDLESS)) as run:
            await run.result()
    assert (await run.result()).status is seoro.RunStatus.CANCELLED


@pytest.mark.parametrize("error", [KeyError("mine"), SystemExit(3), KeyboardInterrupt()])
async def test_exceptions_of_the_block_are_not_wrapped(
    load: Callable[[str], seoro.Scenario], error: BaseException
) -> None:
    caught: BaseException | None = None
    try:
        async with seoro.start(load(ENDLESS)) as run:
            await asyncio.sleep(0)
            raise error
    except BaseException as raised:
        caught = raised
    assert caught is error
    assert (await run.result()).status is seoro.RunStatus.CANCELLED


async def test_an_empty_block_cancels_the_run(load: Callable[[str], seoro.Scenario]) -> None:
    async with seoro.start(load(ENDLESS), clock="virtual") as run:
        pass
    verdict = await run.result()
    assert verdict.status is seoro.RunStatus.CANCELLED
    assert verdict.reason == "the block that started it has ended"


async def test_a_run_in_an_async_generator_is_stopped_with_it(load: Callable[[str], seoro.Scenario]) -> None:
    async def logs() -> AsyncIterator[seoro.Run]:
        async with seoro.start(load(ENDLESS)) as run:
            yield run

    generator = logs()
    run = await anext(generator)
    await generator.aclose()  # type: ignore[attr-defined]
    assert (await run.result()).status is seoro.RunStatus.CANCELLED


async def test_an_unknown_option_starts_nothing(load: Callable[[str], seoro.Scenario]) -> None:
    scenario = load(ENDLESS)
    for options, message in (
        ({"seed": -1}, "invalid seed -1"),
        ({"clock": "fast"}, "unknown clock 'fast'"),
        ({"clock": "sim"}, "needs a simulator"),
        ({"grace": -1.0}, "expected seconds from 0"),
        ({"clock": "virtual", "simulator": seoro.Simulator(name="mujoco")}, "is impossible with a simulator"),
        ({"simulator": seoro.Simulator()}, "expected either the name of a simulator"),
    ):
        with pytest.raises(seoro.UsageError, match=message):
            async with seoro.start(scenario, **options):
                pytest.fail("it was started")
