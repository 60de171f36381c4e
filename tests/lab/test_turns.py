"""Runs on an executor that wait for robots: they block no other runs, and get a slot with their robots."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.cli.main import main
from seoro.client.runs import RemoteRun
from seoro.executor.limits import Limits, Policy
from seoro.executor.runs import run_slots as turns
from seoro.executor.service import ExecutorOptions, open_executor
from seoro.lab.commands import LabCommands
from tests.bridges.robot.conftest import Rails
from tests.executors import HELLO, LONG, NAME, RunningExecutor, executor
from tests.lab.test_runs import ALONE, floor, lab_of

DEADLINE = 40.0  # [s]
PATIENT = seoro.Leasing(wait=600.0)
HOLDER = "new wheels"


@pytest.fixture
def lab(rails: Rails, tmp_path: Path) -> seoro.Lab:
    (tmp_path / "go.osc").write_text(ALONE)
    (tmp_path / "hello.osc").write_text(HELLO)
    (tmp_path / "long.osc").write_text(LONG)
    return lab_of(tmp_path, floor(rails, "leader=line"))


@asynccontextmanager
async def executing_at(folder: Path, **limits: object) -> AsyncIterator[seoro.Client]:
    """Yield a client of an executor in this process."""
    endpoint = f"unixsock-stream/{folder}/hub"
    policy = Policy(everybody=Limits.model_validate(limits))
    made = ExecutorOptions(NAME, folder / "state", listen=endpoint, policy=policy)
    async with open_executor(made), seoro.Client(endpoint) as client:
        yield client


@asynccontextmanager
async def holding(rails: Rails) -> AsyncIterator[None]:
    """Lease the robot; a lease needs no heartbeats of a busy machine."""
    place = (("line", rails.endpoint),)
    with anyio.fail_after(DEADLINE):  # those of an earlier test may have a place in line, still
        while any(
            each.error for each in await LabCommands([rails.endpoint]).lease(place, "a-test", HOLDER, 600.0)
        ):
            await anyio.sleep(0.1)
    yield
    await LabCommands([rails.endpoint]).release_lease(place[0])


async def patient(client: seoro.Client, lab: seoro.Lab) -> RemoteRun:
    """Submit a run that waits for its robot."""
    bound = {"leader": "robot:leader"}
    run = await client.submit(NAME, lab.file.with_name("go.osc"), lab=lab, leasing=PATIENT, overrides=bound)
    await waiting_for(run, HOLDER)
    return run


async def waiting_for(run: RemoteRun, whom: str) -> None:
    with anyio.fail_after(DEADLINE):
        async for info, _ in run.parts():
            if whom in info.waits:
                assert info.state is State.QUEUED
                return


async def begun(run: RemoteRun) -> None:
    with anyio.fail_after(DEADLINE):
        async for record in run.records():
            if record["kind"] == "log":
                return


async def passes(run: RemoteRun) -> bool:
    with anyio.fail_after(DEADLINE):
        return (await run.result()).passed


async def test_a_run_that_waits_for_robots_delays_no_other(rails: Rails, lab: seoro.Lab, tmp_path: Path) -> None:
    with executor(tmp_path) as there:
        async with seoro.Client(there.endpoint) as client:
            async with holding(rails):
                waiting = await patient(client, lab)
                other = await client.submit(NAME, tmp_path / "hello.osc")
                assert await passes(other)
                [status] = await client.describe()
                assert status.info.waiting == 1
            assert await passes(waiting)
            assert waiting.info.waits == ""


@pytest.mark.more
async def test_a_run_with_its_robots_waits_for_its_turn(rails: Rails, lab: seoro.Lab, tmp_path: Path) -> None:
    async with executing_at(tmp_path) as client:
        async with holding(rails):
            waiting = await patient(client, lab)
            other = await client.submit(NAME, tmp_path / "long.osc")
            await begun(other)
            last = await client.submit(NAME, tmp_path / "hello.osc")
        await waiting_for(waiting, "waits for a free run slot")
        assert (await client.run(last.id)).info.place == 1
        await other.stop()
        assert await passes(waiting)
        assert await passes(last)
        started = [(await client.run(run.id)).info.started or 0.0 for run in (waiting, last)]
        assert started == sorted(started)


@pytest.mark.more
async def test_a_run_stopped_while_it_waits_holds_no_robots(rails: Rails, lab: seoro.Lab, tmp_path: Path) -> None:
    async def stop(run: RemoteRun) -> None:
        await run.stop("the test is over")
        with pytest.raises(seoro.BackendError, match="the run is cancelled: the test is over"):
            await run.result()

    async with executing_at(tmp_path) as client:
        async with holding(rails):
            runs = [await patient(client, lab) for _ in range(2)]
            await stop(runs[0])
            other = await client.submit(NAME, tmp_path / "long.osc")
            await begun(other)
        await waiting_for(runs[1], "waits for a free run slot")
        await stop(runs[1])
        async with holding(rails):
            await other.stop()
            await other.result()


@pytest.mark.more
@pytest.mark.parametrize("end", [RunningExecutor.end, RunningExecutor.kill])
async def test_a_waiting_run_starts_after_a_restart_of_the_executor(
    rails: Rails, lab: seoro.Lab, tmp_path: Path, end: object
) -> None:
    async with holding(rails):
        with executor(tmp_path) as there:
            async with seoro.Client(there.endpoint) as client:
                run = await patient(client, lab)
            await anyio.to_thread.run_sync(end, there)  # type: ignore[arg-type]
    with executor(tmp_path) as there:
        async with seoro.Client(there.endpoint) as client:
            again = await client.run(run.id)
            assert await passes(again)


@pytest.mark.more
async def test_the_number_of_waiting_runs_is_limited(
    rails: Rails, lab: seoro.Lab, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(turns, "MOST_LENT", 1)
    async with executing_at(tmp_path) as client:
        async with holding(rails):
            first = await patient(client, lab)
            second = await client.submit(NAME, tmp_path / "go.osc", lab=lab, leasing=PATIENT)
            other = await client.submit(NAME, tmp_path / "hello.osc")
            assert await passes(other)
            info = (await client.run(second.id)).info
            assert (info.state, info.place, info.waits) == (State.QUEUED, 1, "")
        for run in (first, second):
            assert await passes(run)


@pytest.mark.more
async def test_waiting_does_not_use_the_time_limit_of_a_run(rails: Rails, lab: seoro.Lab, tmp_path: Path) -> None:
    async with executing_at(tmp_path, time=5.0) as client:
        async with holding(rails):
            run = await patient(client, lab)
            await anyio.sleep(5.2)
        assert await passes(run)


def test_the_holder_that_a_run_waits_for_is_shown(
    rails: Rails,
    lab: seoro.Lab,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    async def follow() -> tuple[str, str]:
        command = ["-m", "seoro", "exec", str(tmp_path / "go.osc"), "--on", NAME, "--lab", str(lab.file)]
        async with holding(rails):
            with subprocess.Popen(
                [sys.executable, *command, "--when-free"], stderr=subprocess.PIPE, text=True
            ) as running:
                assert running.stderr is not None
                note = await anyio.to_thread.run_sync(running.stderr.readline)
                assert await anyio.to_thread.run_sync(main, ["ps"]) == 0
                running.kill()
        return note, capsys.readouterr().out

    with executor(tmp_path) as there:
        monkeypatch.setenv("SEORO_EXECUTOR", there.endpoint)
        note, table = anyio.run(follow)
    assert "waits: cannot acquire the robots of the bridge 'rails': 'line' is leased until" in note
    [titles, row] = table.splitlines()
    assert row[titles.index("WAITING FOR") :].startswith("cannot acquire the robots of the bridge 'rails': 'line'")
