"""Loops of behaviors without time: other tasks of the event loop have turns, and the loops end."""

import asyncio
import logging
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.runtime.execution import loops as endless
from seoro.runtime.kernel import stepping
from tests.executors import HELLO

ENDLESS = """import osc.helpers
scenario endless:
    do log("x") with:
        repeat()
"""
BOTH = """parallel:
            log("a")
            serial:
                log("b")
                wait elapsed(1s)
                log("c")"""


def made(folder: Path, text: str) -> seoro.Scenario:
    file = folder / "some.osc"
    file.write_text(text)
    return seoro.load(file)


async def test_a_loop_without_time_is_stopped_at_once(tmp_path: Path) -> None:
    async with seoro.start(made(tmp_path, ENDLESS), clock="virtual") as run:
        turns = 0
        with anyio.move_on_after(0.3):
            while True:
                await asyncio.sleep(0)
                turns += 1
        run.stop("enough")
        with anyio.fail_after(30.0):
            verdict = await run.result()
    assert turns > 0
    assert verdict.status is seoro.RunStatus.CANCELLED
    assert verdict.reason == "enough"


async def test_a_loop_without_time_ends_by_processor_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(endless, "NOTE_AFTER", 0.01)
    monkeypatch.setattr(endless, "PROCESSOR_TIME", 0.05)
    with caplog.at_level(logging.WARNING):
        async with seoro.start(made(tmp_path, ENDLESS), clock="virtual") as run:
            verdict = await run.result()
    assert verdict.status is seoro.RunStatus.ERROR
    assert "limit reached" in verdict.reason
    assert "more than 0.05 s" in verdict.reason
    [record] = caplog.records
    assert "started without time passing" in record.getMessage()


@pytest.mark.parametrize("slice_", [0.0, stepping.SLICE])
async def test_yielding_to_other_tasks_does_not_change_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, slice_: float
) -> None:
    monkeypatch.setattr(stepping, "SLICE", slice_)
    text = HELLO.replace('log("hello")', BOTH)
    async with seoro.start(made(tmp_path, text), clock="virtual", seed=1, keep_trace=True) as run:
        verdict = await run.result()
        records = [record async for record in run.trace()]
    assert verdict.passed
    assert [record["message"] for record in records if record["kind"] == "log"] == ["a", "b", "c"]
