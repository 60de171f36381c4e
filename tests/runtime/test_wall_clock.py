"""The clock of the machine: jumps of its date have no effect, and timers are never early."""

from __future__ import annotations

import asyncio
import time
from datetime import UTC, datetime

import pytest

from seoro.embed.options import Options
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.functions.actions import action
from tests.runtime.conftest import Prepare

TEXT = """
scenario main:
    var ticks: int = sample(ticks + 1, every(50ms), 0)
    do serial:
        wait elapsed(100ms)
        log("waited")
        wait elapsed(5s)
    with:
        until ticks >= 6
"""
TIMERS = 40
DAY = 86_400.0  # [s]


class Jumping:
    """A date that jumps back and forth by days at each reading."""

    def __init__(self) -> None:
        self.reads = 0

    def seconds(self) -> float:
        """Replace `time.time`."""
        self.reads += 1
        return 1.7e9 + (DAY if self.reads % 2 else -DAY) * self.reads

    def nanoseconds(self) -> int:
        """Replace `time.time_ns`."""
        return round(self.seconds() * 1e9)


async def test_a_jump_of_the_date_changes_only_stamps(
    prepare_text: Prepare, monkeypatch: pytest.MonkeyPatch
) -> None:
    jumping = Jumping()
    monkeypatch.setattr(time, "time", jumping.seconds)
    monkeypatch.setattr(time, "time_ns", jumping.nanoseconds)
    start = time.monotonic()
    async with prepare_text(TEXT, Options(clock="real")) as run, asyncio.timeout(20.0), run.running():
        records = [record async for record in run.trace()]
        verdict = await run.result()
    took = time.monotonic() - start
    assert jumping.reads > len(records) / 2, "the date has jumped"
    assert verdict.passed, verdict.reason
    assert 0.25 <= verdict.duration <= took
    assert 0.25 <= verdict.wall_duration <= took
    times = [record["t"] for record in records]
    assert times == sorted(times)
    stamps = [datetime.fromisoformat(record["wall"]) for record in records]
    assert stamps != sorted(stamps)
    assert all(stamp.tzinfo == UTC for stamp in stamps)
    [waited] = [record["t"] for record in records if record["kind"] == "log"]
    assert 0.1 <= waited <= verdict.duration


async def test_timers_of_the_machine_are_never_early(prepare_text: Prepare) -> None:
    due = [0.003 + 0.0071 * number for number in range(TIMERS)]
    lines = "".join(
        f"        serial:\n            wait elapsed({seconds:.4f}s)\n            log('{seconds:.4f}')\n"
        for seconds in due
    )
    async with (
        prepare_text(f"scenario main:\n    do parallel:\n{lines}", Options(clock="real")) as run,
        asyncio.timeout(20.0),
        run.running(),
    ):
        logged = [(r["t"], float(r["message"])) async for r in run.trace() if r["kind"] == "log"]
    assert len(logged) == TIMERS
    for at, seconds in logged:
        assert at >= seconds


@action("hum", open_ended=True)
async def hum(ctx: ActionContext) -> None:
    """Wait for the cancellation; stopping takes real time."""
    try:
        await ctx.sleep(60.0)
    finally:
        await asyncio.sleep(0.02)


async def test_members_ended_with_the_primary_one_may_take_time_to_clean_up(prepare_text: Prepare) -> None:
    text = """
action hum

scenario main:
    do parallel(overlap: equal):
        wait elapsed(50ms)
        hum()
        hum()
"""
    async with prepare_text(text, Options(clock="real"), [hum]) as run, asyncio.timeout(20.0), run.running():
        verdict = await run.result()
    assert verdict.passed, verdict.reason
