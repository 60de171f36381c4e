"""Runs that are cancelled at each of their wake-ups: they end as cancelled, without leftovers."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any, Literal

import pytest

from seoro import ActionContext, Actor, action
from seoro.embed import Scenario
from seoro.lang.frontend import lower
from seoro.lang.plan import Plan
from seoro.runtime.execution.settings import Settings
from seoro.runtime.kernel.clock import VirtualClock
from seoro.runtime.run import Execution
from seoro.runtime.verdict import RunStatus, Verdict
from tests.leftovers import Leftovers
from tests.runtime.cancelled_scenarios import BODIES, text_of
from tests.runtime.conftest import load_text

MOST = 200  # wake-ups at which the run of one scenario is cancelled
FEW = 4  # of these in the short test
HANGS = 20.0  # [s] of the machine's clock

How = Literal["stop", "cancel"]


@action("hold", open_ended=True)
async def hold(ctx: ActionContext) -> None:
    await ctx.sleep(1e6)


@action("clean")
async def clean(ctx: ActionContext) -> None:
    """Sleep for 2 s; the clean-up takes a step, a second, and turns of the event loop."""
    try:
        await ctx.sleep(2.0)
    finally:
        await ctx.sleep(1.0)
        await asyncio.sleep(0)


@action("ask")
async def ask(ctx: ActionContext) -> None:
    """Await the event loop, also in child tasks."""
    async with asyncio.TaskGroup() as group:
        group.create_task(asyncio.sleep(0.001))
        group.create_task(asyncio.sleep(0))


@asynccontextmanager
async def opened() -> AsyncGenerator[None]:
    await asyncio.sleep(0)
    try:
        yield
    finally:
        await asyncio.sleep(0)


@action("keep_open")
async def keep_open(ctx: ActionContext) -> None:
    await ctx.keep(opened())


@action("robot.move", uses="base")
async def move(ctx: ActionContext, actor: Actor) -> None:
    await ctx.sleep(1.0)


ACTIONS = (hold, clean, ask, keep_open, move)


@pytest.fixture(autouse=True)
def _a_turn_for_each_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give each step of a single task its own delta cycle, after a turn of the event loop.

    Every step is then an observable wake-up, also on a busy machine, and a cancellation arrives at it.
    """
    monkeypatch.setattr("seoro.runtime.kernel.stepping.LOOK_EVERY", 0)
    monkeypatch.setattr("seoro.runtime.kernel.stepping.SLICE", -1.0)


class WakeUps:
    """A counter of the wake-ups of a run: steps of tasks that are scheduled for the next delta cycle.

    Args:
        act_at: Number of the wake-up at which `act` is called; None for no call.
    """

    def __init__(self, act_at: int | None) -> None:
        self.count = 0
        self.act: Callable[[], None]
        self._act_at = act_at

    def order(self, path: tuple[int, ...]) -> tuple[int, ...]:
        """Note a wake-up; return its default order."""
        self.count += 1
        if self.count == self._act_at:
            self.act()
        return path


class Records:
    """Observer of the kinds of records of a trace."""

    def __init__(self) -> None:
        self.kinds: list[str] = []

    def record(self, record: dict[str, Any]) -> None:
        self.kinds.append(record["kind"])


class Cancelled:
    """A run of a scenario that is cancelled at one of its wake-ups.

    Args:
        scenario: Scenario to run.
        plan: Plan of the scenario.
    """

    def __init__(self, scenario: Scenario, plan: Plan) -> None:
        self._scenario = scenario
        self._plan = plan
        self.was_decided = False

    async def run(self, act_at: int | None, how: How) -> tuple[Verdict, int]:
        """Run to the end; return the verdict and the number of wake-ups."""
        wake_ups, records = WakeUps(act_at), Records()
        settings = Settings(
            seed=1,
            clock=VirtualClock(),
            observers=[records],
            actions=self._scenario.functions.actions,
            modifiers=self._scenario.functions.modifiers,
            step_order=wake_ups.order,
        )
        execution = Execution(self._plan, settings)
        running = asyncio.ensure_future(execution.run())

        def cancel() -> None:
            self.was_decided = execution._services.decision is not None
            if how == "stop":
                execution.stop("by the test")
            else:
                running.cancel()

        wake_ups.act = cancel
        async with asyncio.timeout(HANGS):
            with suppress(asyncio.CancelledError):
                await running
        assert execution.verdict is not None
        assert records.kinds[-1] == "run.end"
        assert records.kinds.count("behavior.start") == records.kinds.count("behavior.end")
        return execution.verdict, wake_ups.count


async def check_cancelled(folder: Path, name: str, how: How, most: int, leftovers: Leftovers) -> None:
    """Cancel the run of a scenario at some of its wake-ups."""
    scenario = load_text(folder, text_of(name), ACTIONS)
    cancelled = Cancelled(scenario, lower(scenario.checked))
    whole, count = await cancelled.run(None, how)
    times = range(1, count + 1)
    if count > most:
        times = range(1, count + 1, -(-count // most))
    for number in times:
        verdict, _ = await cancelled.run(number, how)
        if how == "stop" and not cancelled.was_decided:
            assert verdict.status is RunStatus.CANCELLED, f"at wake-up {number} of {count}"
            assert verdict.reason == "by the test"
        else:  # the cancellation arrives with the next turn of the event loop, when the run may be over
            assert verdict.status in (RunStatus.CANCELLED, whole.status), f"at wake-up {number} of {count}"
    assert leftovers.runs == len(times) + 1


def test_fifty_scenarios_are_tested() -> None:
    assert len(BODIES) >= 50


@pytest.mark.parametrize("name", BODIES)
async def test_a_stopped_run_leaves_nothing_behind(name: str, tmp_path: Path, leftovers: Leftovers) -> None:
    await check_cancelled(tmp_path, name, "stop", FEW, leftovers)


@pytest.mark.parametrize("name", ["serial", "parallel in parallel", "actions with clean-up in a row"])
async def test_a_run_whose_task_is_cancelled_leaves_no_tasks(
    name: str, tmp_path: Path, leftovers: Leftovers
) -> None:
    await check_cancelled(tmp_path, name, "cancel", FEW, leftovers)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["stop", "cancel"])
@pytest.mark.parametrize("name", BODIES)
async def test_a_run_cancelled_at_any_wake_up_leaves_nothing_behind(
    name: str, how: How, tmp_path: Path, leftovers: Leftovers
) -> None:
    await check_cancelled(tmp_path, name, how, MOST, leftovers)
