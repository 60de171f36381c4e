"""Arrivals from the outside world while a run waits."""

import asyncio

import pytest

from seoro import ActionContext, action
from seoro.embed.options import Options
from seoro.runtime.actions.pending import Pending
from seoro.runtime.contracts.backends import GoalStatus, Report
from tests.runtime.conftest import Prepare

DONE = Report(GoalStatus.SUCCEEDED)
TEXT = """
action listen:
    index: int
scenario main:
    do parallel:
        serial:
            listen(0)
            log("received 0")
        serial:
            listen(1)
            log("received 1")
    with:
        timeout({limit})
"""


class Outside:
    """Two awaited reports, and a list of events in order."""

    def __init__(self) -> None:
        self.pending = [Pending(), Pending()]
        self.happened: list[str] = []

    async def wait_expected(self) -> None:
        """Wait until tasks await both reports."""
        while any(each.waiter is None for each in self.pending):
            await asyncio.sleep(0.001)
        await asyncio.sleep(0.01)  # the instant has settled by then

    def arrive(self, *indices: int) -> None:
        """Deliver some of the reports."""
        for index in indices:
            self.pending[index].settle(DONE)
        asyncio.get_running_loop().call_soon(self.happened.append, "turn")


@pytest.mark.parametrize("limit", ["60s", "3600s"])
async def test_an_action_resumes_in_the_next_turn_of_the_event_loop(prepare_text: Prepare, limit: str) -> None:
    outside = Outside()

    @action("listen")
    async def listen(ctx: ActionContext, index: int) -> None:
        await ctx.report(outside.pending[index])
        outside.happened.append(f"received {index}")

    text = TEXT.format(limit=limit)
    async with asyncio.timeout(20), prepare_text(text, Options(clock="real"), (listen,)) as run, run.running():
        await outside.wait_expected()
        outside.arrive(1)
        await asyncio.sleep(0.01)
        outside.arrive(0)
        verdict = await run.result()
    assert outside.happened == ["received 1", "turn", "received 0", "turn"]
    assert verdict.passed
    assert verdict.duration < 10


async def test_all_arrivals_of_one_instant_are_received(prepare_text: Prepare) -> None:
    outside = Outside()

    @action("listen")
    async def listen(ctx: ActionContext, index: int) -> None:
        await ctx.report(outside.pending[index])

    text = TEXT.format(limit="60s")
    async with asyncio.timeout(20), prepare_text(text, Options(clock="real"), (listen,)) as run, run.running():
        await outside.wait_expected()
        outside.arrive(1, 0, 1)
        records = [record async for record in run.trace()]
        verdict = await run.result()
    assert verdict.passed
    logs = [(record["t"], record["message"]) for record in records if record["kind"] == "log"]
    assert sorted(message for _, message in logs) == ["received 0", "received 1"]
    assert len({time for time, _ in logs}) == 1, "of one instant"
