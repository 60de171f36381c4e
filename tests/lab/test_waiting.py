"""Runs that wait until others do not need their robots any more."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.robot.connecting import RobotsTaken, connect_robots
from seoro.errors import BackendUnreachable
from seoro.lab.waiting import LONGEST_RETRY, RETRY, _Patience
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


async def test_a_run_fails_at_once_that_does_not_wait(
    rails: Rails, scenario: seoro.Scenario, tmp_path: Path
) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    async with connect_robots(rails.endpoint, "the first run"):
        with pytest.raises(RobotsTaken, match="held by the first run"):
            await verdict_of(scenario, lab, seoro.Leasing())


async def test_a_run_that_waits_says_for_whom_and_begins_when_it_can(
    rails: Rails, scenario: seoro.Scenario, tmp_path: Path
) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    said: list[str] = []
    async with anyio.create_task_group() as tasks:

        async def hold() -> None:
            async with connect_robots(rails.endpoint, "the first run"):
                while not said:
                    await anyio.sleep(0.05)

        tasks.start_soon(hold)
        await anyio.sleep(0.3)
        verdict = await verdict_of(scenario, lab, seoro.Leasing(wait=20.0, say=said.append))
    assert verdict.status is RunStatus.PASSED
    (waiting,) = said
    assert "cannot be had: 'line' is held by the first run" in waiting


async def test_a_run_waits_for_as_long_as_it_says(rails: Rails, scenario: seoro.Scenario, tmp_path: Path) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    async with connect_robots(rails.endpoint, "the first run"):
        with pytest.raises(RobotsTaken):
            await verdict_of(scenario, lab, seoro.Leasing(wait=0.5))


async def test_those_who_wait_all_come_and_the_more_urgent_first(
    start_rails: Callable[..., Rails], scenario: seoro.Scenario, tmp_path: Path
) -> None:
    first = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails")
    lab = lab_of(tmp_path, floor(first, "leader=line"))
    order: list[str] = []

    async def one(name: str, priority: int) -> None:
        verdict = await verdict_of(scenario, lab, seoro.Leasing(wait=60.0, priority=priority))
        assert verdict.status is RunStatus.PASSED
        order.append(name)

    async with connect_robots(first.endpoint, "the first run"):
        waiting = []
        for name, priority in (("usual", 0), ("also usual", 0), ("urgent", 5)):
            waiting.append(asyncio.create_task(one(name, priority)))
            await anyio.sleep(0.5)
    await asyncio.gather(*waiting)
    assert order == ["urgent", "usual", "also usual"]


async def test_a_run_that_waits_also_waits_for_a_bridge_that_is_not_there_yet(
    start_rails: Callable[..., Rails], scenario: seoro.Scenario, tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/rails"
    lab = lab_of(tmp_path, FLOOR_AT.format(endpoint))
    said: list[str] = []

    def start_when_waited_for(reason: str) -> None:
        if not said:
            start_rails("--listen", endpoint)
        said.append(reason)

    verdict = await verdict_of(scenario, lab, seoro.Leasing(wait=30.0, say=start_when_waited_for))
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert f"cannot connect to {endpoint}: nothing answers there" in said[0]


async def test_a_bridge_that_does_not_come_is_an_error_once_the_run_waits_no_longer(
    scenario: seoro.Scenario, tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/nobody"
    lab = lab_of(tmp_path, FLOOR_AT.format(endpoint))
    for leasing in (seoro.Leasing(), seoro.Leasing(wait=0.3)):
        with pytest.raises(BackendUnreachable, match="nothing answers there"):
            await verdict_of(scenario, lab, leasing)


def test_pauses_grow_while_a_node_does_not_answer_and_are_bounded() -> None:
    patience = _Patience(seoro.Leasing(wait=math.inf))
    pauses = []
    for _ in range(12):
        patience.report(BackendUnreachable("nobody is there"))
        pauses.append(patience.pause())
    assert pauses[0] < 1.0
    assert pauses[-1] == LONGEST_RETRY
    patience.report(RobotsTaken("another run has them"))
    assert patience.pause() <= RETRY[1]
