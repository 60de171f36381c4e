"""Warnings about actions that block the event loop."""

import asyncio
import os
import time
from collections.abc import Callable
from typing import Any

import pytest

from seoro import ActionContext, action
from seoro.embed.options import Options
from seoro.runtime.execution import blocking
from tests.runtime.conftest import Prepare, Ran, RunText

TEXT = """
action work
scenario main:
    do work() with:
        repeat(3)
"""


@pytest.fixture(autouse=True)
def limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the limit, so that tests need not block for long."""
    monkeypatch.setattr(blocking, "LIMIT", 0.02)


def warnings(ran: Ran) -> list[str]:
    return [record["message"] for record in ran.records if record.get("level") == "warning"]


def line_of(function: Callable[..., object], offset: int) -> int:
    return function.__code__.co_firstlineno + offset


async def test_a_blocking_action_is_reported_once_with_its_lines(run_text: RunText) -> None:
    @action("work")
    async def work(ctx: ActionContext) -> None:
        await ctx.sleep(1.0)
        time.sleep(0.03)
        await ctx.sleep(1.0)

    ran = await run_text(TEXT, actions=[work])
    [warning] = warnings(ran)
    assert warning.startswith("`work` blocked the event loop for 0.0")
    first, last = line_of(work, 2), line_of(work, 4)
    assert f"(in `work`, tests/runtime/execution/test_blocking.py:{first} to {last})" in warning
    assert "thread=True" in warning
    [record] = [record for record in ran.records if record.get("level") == "warning"]
    assert record["source"].endswith("test.osc:7:8")
    assert record["t"] == 1.0


async def test_a_blocking_last_step_of_an_action_is_reported(run_text: RunText) -> None:
    @action("work")
    async def work(ctx: ActionContext) -> None:
        time.sleep(0.03)

    [warning] = warnings(await run_text(TEXT, actions=[work]))
    assert f"test_blocking.py:{line_of(work, 0)} to its end)" in warning


async def test_blocking_of_other_tasks_is_not_attributed_to_an_action(prepare_text: Prepare) -> None:
    @action("work")
    async def work(ctx: ActionContext) -> None:
        ctx.log("to someone slow")
        await ctx.sleep(0.0)
        await asyncio.sleep(0.03)

    class Slow:
        def record(self, record: dict[str, object]) -> None:
            if record["kind"] == "log":
                time.sleep(0.03)

    async with prepare_text(TEXT, Options(clock="virtual", observers=[Slow()]), [work]) as run, run.running():
        records = [record async for record in run.trace()]
        assert [r["message"] for r in records if r["kind"] == "log"] == ["to someone slow"] * 3


async def test_a_run_opens_one_proc_file_and_closes_it(run_text: RunText, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[int] = []
    open_file = os.open

    def note(*arguments: Any) -> int:
        file = open_file(*arguments)
        if str(arguments[0]).startswith("/proc"):  # libraries are read meanwhile, too
            opened.append(file)
        return file

    @action("work")
    async def work(ctx: ActionContext) -> None:
        for _ in range(3):
            await ctx.sleep(1.0)

    monkeypatch.setattr(blocking, "_RENEWAL", -1.0)
    monkeypatch.setattr(os, "open", note)
    ran = await run_text(TEXT, actions=[work])
    assert ran.verdict.passed
    assert len(opened) == 1
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(opened[0])
