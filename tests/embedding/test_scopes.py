"""Cancel scopes and time limits of a program reach through a run: it is stopped and cleans up."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, Literal, TypeAlias

import anyio
import pytest

import seoro
from seoro import ActionContext, action
from tests.embedding.conftest import holdings

TEXT = """import osc.helpers

action slow

scenario main:
    event never
    do parallel:
        slow()
        serial:
            log("begun")
            wait @never
"""

Expire: TypeAlias = Callable[[], object]
Limit: TypeAlias = Callable[[], AbstractAsyncContextManager[Expire]]
Clock: TypeAlias = Literal["virtual", "real"]

cleaned_up: list[str] = []


@action("slow")
async def slow(ctx: ActionContext) -> None:
    """Waits for ever, and takes turns of the event loop to clean up."""
    try:
        await asyncio.get_running_loop().create_future()
    finally:
        for _ in range(10):
            await asyncio.sleep(0)
        cleaned_up.append("slow")


@pytest.fixture
def scenario(tmp_path: Path) -> seoro.Scenario:
    module = ModuleType("slow_actions")
    module.slow = slow  # type: ignore[attr-defined]
    (tmp_path / "slow.osc").write_text(TEXT)
    cleaned_up.clear()
    return seoro.load(tmp_path / "slow.osc", modules=[module])


@asynccontextmanager
async def fail_after() -> AsyncIterator[Expire]:
    with anyio.fail_after(3600) as scope:
        yield lambda: setattr(scope, "deadline", anyio.current_time())


@asynccontextmanager
async def move_on_after() -> AsyncIterator[Expire]:
    with anyio.move_on_after(3600) as scope:
        yield lambda: setattr(scope, "deadline", anyio.current_time())
    assert scope.cancelled_caught
    raise TimeoutError


@asynccontextmanager
async def cancel_scope() -> AsyncIterator[Expire]:
    with anyio.CancelScope() as scope:
        yield scope.cancel
    assert scope.cancelled_caught
    raise TimeoutError


@asynccontextmanager
async def timeout() -> AsyncIterator[Expire]:
    async with asyncio.timeout(3600) as limit:
        yield lambda: limit.reschedule(asyncio.get_running_loop().time())


@asynccontextmanager
async def wait_for_task() -> AsyncIterator[Expire]:
    """Cancel a task as `asyncio.wait_for` does."""
    task = asyncio.current_task()
    assert task is not None
    try:
        yield task.cancel
    except asyncio.CancelledError:
        task.uncancel()
        raise TimeoutError from None


LIMITS = pytest.mark.parametrize("limit", [fail_after, move_on_after, cancel_scope, timeout, wait_for_task])
CLOCKS = pytest.mark.parametrize("clock", ["virtual", "real"])


class ExpiresAtLog:
    """Lets a limit expire when the scenario writes a log, and keeps the trace."""

    def __init__(self) -> None:
        self.records: list[dict[str, Any]] = []
        self.expire: Expire = lambda: None

    def record(self, record: dict[str, Any]) -> None:
        self.records.append(record)
        if record["kind"] == "log":
            self.expire()


def check_cancelled(run: seoro.Run, records: list[dict[str, Any]]) -> None:
    assert cleaned_up == ["slow"]
    assert records[-1]["kind"] == "run.end"
    assert records[-1]["status"] == "cancelled"
    started = {record["id"] for record in records if record["kind"] == "behavior.start"}
    assert started == {record["id"] for record in records if record["kind"] == "behavior.end"}
    assert run.verdict is not None
    assert run.verdict.status is seoro.RunStatus.CANCELLED


@CLOCKS
@LIMITS
async def test_a_limit_around_a_run(scenario: seoro.Scenario, limit: Limit, clock: Clock) -> None:
    held, seen = holdings(), ExpiresAtLog()
    with pytest.raises(TimeoutError):
        async with limit() as seen.expire, seoro.start(scenario, clock=clock, observers=[seen]) as run:
            await run.result()
    check_cancelled(run, seen.records)
    assert not holdings() - held


@CLOCKS
@LIMITS
async def test_a_limit_around_its_result(scenario: seoro.Scenario, limit: Limit, clock: Clock) -> None:
    """The limit is that of waiting: the run continues until its block ends."""
    held, seen = holdings(), ExpiresAtLog()
    async with seoro.start(scenario, clock=clock, observers=[seen]) as run:
        with pytest.raises(TimeoutError):
            async with limit() as seen.expire:
                await run.result()
        assert run.verdict is None
        assert cleaned_up == []
    check_cancelled(run, seen.records)
    assert not holdings() - held


@CLOCKS
@LIMITS
async def test_a_limit_around_an_emission_and_a_subscription(
    scenario: seoro.Scenario, limit: Limit, clock: Clock
) -> None:
    seen = ExpiresAtLog()
    with pytest.raises(TimeoutError):
        async with (
            limit() as seen.expire,
            seoro.start(scenario, clock=clock, observers=[seen], external=["never"]) as run,
            run.subscribe("never") as events,
        ):
            async for _ in events:
                pytest.fail("it does not occur")
    check_cancelled(run, seen.records)


@CLOCKS
async def test_a_run_within_anyio(scenario: seoro.Scenario, clock: Clock) -> None:
    """In a loop that anyio makes, beside tasks of a task group of anyio."""

    async def program() -> seoro.Run:
        seen = ExpiresAtLog()
        async with anyio.create_task_group() as group:
            with pytest.raises(TimeoutError):
                async with (
                    fail_after() as seen.expire,
                    seoro.start(scenario, clock=clock, observers=[seen]) as run,
                ):
                    group.start_soon(anyio.sleep_forever)
                    await run.result()
            group.cancel_scope.cancel()
        check_cancelled(run, seen.records)
        return run

    run = await asyncio.to_thread(anyio.run, program)
    assert (await run.result()).reason


async def test_a_task_group_of_anyio_that_is_cancelled(scenario: seoro.Scenario) -> None:
    runs: list[seoro.Run] = []
    seen = ExpiresAtLog()

    async def one() -> None:
        async with seoro.start(scenario, clock="real", observers=[seen]) as run:
            runs.append(run)
            await run.result()

    async with anyio.create_task_group() as group:
        seen.expire = group.cancel_scope.cancel
        group.start_soon(one)
    check_cancelled(runs[0], seen.records)


WITHOUT_ANYIO = """
import asyncio
import subprocess
import sys
import sys

import seoro

async def program(path):
    async with seoro.start(seoro.load(path), clock="virtual", external=["go"]) as run:
        task = asyncio.create_task(run.result())
        async for record in run.trace():
            if record["kind"] == "log":
                break
        run.stop("enough")
        verdict = await task
        return verdict, [record["kind"] async for record in run.trace()]

verdict, kinds = asyncio.run(program(sys.argv[1]))
assert verdict.status is seoro.RunStatus.CANCELLED, verdict
assert kinds[-1] == "run.end", kinds
print("anyio" in sys.modules)
"""


def test_a_program_without_anyio_runs_and_stops_scenarios_without_it(tmp_path: Path) -> None:
    path = tmp_path / "main.osc"
    path.write_text(
        'import osc.helpers\nscenario main:\n    event go\n    do serial:\n        log("x")\n        wait @go\n'
    )
    command = [sys.executable, "-c", WITHOUT_ANYIO, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "False\n"), done.stderr
