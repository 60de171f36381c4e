"""Runs that wait for robots of other runs."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from pathlib import Path

import pytest

import seoro
from seoro.bridges.robot.connecting import RobotsBusy, connect_robots
from seoro.errors import BackendUnreachable
from seoro.lab.waiting import MAX_RETRY, RETRY, _RetryTimer
from seoro.runtime.verdict import RunStatus
from tests.bridges.robot.conftest import Rails
from tests.lab.test_runs import ALONE, floor, lab_of

pytestmark = pytest.mark.anyio
FLOOR_AT = "bridges: {{floor: {{connect: {}}}}}\nrobots: {{leader: {{in: floor, as: line}}}}\n"


@pytest.fixture
def scenario(tmp_path: Path) -> seoro.Scenario:
    (tmp_path / "go.osc").write_text(ALONE)
    return seoro.load(tmp_path / "go.osc")


async def verdict_of(scenario: seoro.Scenario, lab: seoro.Lab, leasing: seoro.Leasing) -> seoro.Verdict:
    async with seoro.start(scenario, lab=lab, leasing=leasing) as run:
        return await run.result()


class Waits:
    """Reports of a run that waits for robots."""

    def __init__(self) -> None:
        self.begun = asyncio.Event()
        self.messages: list[str] = []

    def leasing(self, priority: int = 0) -> seoro.Leasing:
        return seoro.Leasing(wait=60.0, priority=priority, on_wait=self._report)

    def _report(self, message: str) -> None:
        self.messages.append(message)
        self.begun.set()


async def test_a_run_without_waiting_fails_at_once(rails: Rails, scenario: seoro.Scenario, tmp_path: Path) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    async with connect_robots(rails.endpoint, "the first run"):
        with pytest.raises(RobotsBusy, match="held by the first run"):
            await verdict_of(scenario, lab, seoro.Leasing())


async def test_a_waiting_run_reports_the_holder_and_starts_when_possible(
    rails: Rails, scenario: seoro.Scenario, tmp_path: Path
) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    waits = Waits()
    async with connect_robots(rails.endpoint, "the first run"):
        task = asyncio.create_task(verdict_of(scenario, lab, waits.leasing()))
        await waits.begun.wait()
    assert (await task).status is RunStatus.PASSED
    (waiting,) = waits.messages
    assert "'rails': 'line' is held by the first run" in waiting


async def test_a_run_waits_for_its_limit(rails: Rails, scenario: seoro.Scenario, tmp_path: Path) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    async with connect_robots(rails.endpoint, "the first run"):
        with pytest.raises(RobotsBusy):
            await verdict_of(scenario, lab, seoro.Leasing(wait=0.5))


async def test_all_waiting_runs_start_in_the_order_of_priority(
    start_rails: Callable[..., Rails], scenario: seoro.Scenario, tmp_path: Path
) -> None:
    first = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails")
    lab = lab_of(tmp_path, floor(first, "leader=line"))
    order: list[str] = []

    async def one(name: str, leasing: seoro.Leasing) -> None:
        verdict = await verdict_of(scenario, lab, leasing)
        assert verdict.status is RunStatus.PASSED
        order.append(name)

    async with connect_robots(first.endpoint, "the first run"):
        waiting = []
        for name, priority in (("usual", 0), ("also usual", 0), ("urgent", 5)):
            waits = Waits()
            waiting.append(asyncio.create_task(one(name, waits.leasing(priority))))
            await waits.begun.wait()
    await asyncio.gather(*waiting)
    assert order == ["urgent", "usual", "also usual"]


async def test_a_waiting_run_waits_for_a_missing_bridge(
    start_rails: Callable[..., Rails], scenario: seoro.Scenario, tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/rails"
    lab = lab_of(tmp_path, FLOOR_AT.format(endpoint))
    messages: list[str] = []

    def start_when_waited_for(reason: str) -> None:
        if not messages:
            start_rails("--listen", endpoint)
        messages.append(reason)

    verdict = await verdict_of(scenario, lab, seoro.Leasing(wait=30.0, on_wait=start_when_waited_for))
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert f"cannot connect to {endpoint}: nothing answers there" in messages[0]


async def test_a_missing_bridge_is_an_error_after_the_waiting_limit(
    scenario: seoro.Scenario, tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/nobody"
    lab = lab_of(tmp_path, FLOOR_AT.format(endpoint))
    for leasing in (seoro.Leasing(), seoro.Leasing(wait=0.3)):
        with pytest.raises(BackendUnreachable, match="nothing answers there"):
            await verdict_of(scenario, lab, leasing)


def test_pauses_grow_to_a_bound_while_a_node_does_not_answer() -> None:
    patience = _RetryTimer(seoro.Leasing(wait=math.inf))
    pauses = []
    for _ in range(12):
        patience.report(BackendUnreachable("the node is unreachable"))
        pauses.append(patience.pause())
    assert pauses[0] < 1.0
    assert pauses[-1] == MAX_RETRY
    patience.report(RobotsBusy("another run has them"))
    assert patience.pause() <= RETRY[1]
