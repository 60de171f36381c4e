"""A simulator that hangs during a grant, and a run that is stopped meanwhile."""

import asyncio

import anyio
import pytest

from seoro.embed.options import Options
from seoro.runtime.kernel.clock import VirtualClock
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Prepare

HANGS = 60.0  # [s]


@pytest.mark.parametrize("ending", ["stop", "abort"])
async def test_a_stopped_run_does_not_wait_for_a_hanging_clock(
    prepare_text: Prepare, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    hangs, given_up = asyncio.Event(), asyncio.Event()

    async def pass_time(clock: VirtualClock, due: float | None, interrupt: anyio.Event) -> None:
        hangs.set()
        try:
            await anyio.sleep(HANGS)
        except asyncio.CancelledError:
            given_up.set()
            raise

    monkeypatch.setattr("seoro.runtime.kernel.advance.PATIENCE", 0.01)
    monkeypatch.setattr(VirtualClock, "skip", lambda clock, due: False)
    monkeypatch.setattr(VirtualClock, "pass_time", pass_time)
    text = "scenario main:\n    do wait elapsed(1s)\n"
    async with prepare_text(text, Options(clock="virtual")) as run, run.running():
        await hangs.wait()
        getattr(run, ending)("enough")
        verdict = await run.result()
    assert verdict.status is (RunStatus.CANCELLED if ending == "stop" else RunStatus.ERROR)
    assert verdict.reason == "enough"
    assert given_up.is_set()


async def test_a_granted_advance_is_awaited(prepare_text: Prepare, monkeypatch: pytest.MonkeyPatch) -> None:
    hangs, goes_on = asyncio.Event(), asyncio.Event()

    async def pass_time(clock: VirtualClock, due: float | None, interrupt: anyio.Event) -> None:
        hangs.set()
        await goes_on.wait()
        clock._now = 0.5

    monkeypatch.setattr(VirtualClock, "skip", lambda clock, due: False)
    monkeypatch.setattr(VirtualClock, "pass_time", pass_time)
    text = "scenario main:\n    do wait elapsed(1s)\n"
    async with prepare_text(text, Options(clock="virtual")) as run, run.running():
        await hangs.wait()
        run.stop("enough")
        goes_on.set()
        verdict = await run.result()
    assert (verdict.status, verdict.duration) == (RunStatus.CANCELLED, 0.5)
