"""Processes that take part in a run on an executor are killed, frozen and started again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import anyio
import anyio.to_thread
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.cli.main import main
from seoro.client.runs import RemoteRun
from tests.bridges.robot.conftest import rails_at
from tests.executors import HELLO, LONG, NAME, RunningExecutor, executor
from tests.faults.checks import DEADLINE, check_sequence, follow, measured
from tests.routers import free_endpoint, process, router_process

TICKS = """import osc.helpers
scenario ticks:
    event tick
    on every(20ms):
        emit tick
    do serial:
        log("begun")
        wait elapsed({seconds}s)
"""
DRIVE = """import osc.helpers
import osc.nav2
scenario far_away:
    robot: differential_drive_robot
    do serial:
        robot.init_nav2(pose_3d())
        robot.nav_to_pose(pose_3d(position: position_3d(x: 90m)))
"""
SIMULATED = """import osc.driving
scenario main:
    robot: differential_drive_robot
    do robot.drive(linear: 0.1mps, duration: 60s)
"""


def write(folder: Path, text: str, name: str = "test.osc") -> Path:
    path = folder / name
    path.write_text(text)
    return path


async def begun(run: RemoteRun) -> None:
    """Wait until a run has its first records."""
    async for info, records in run.parts():
        if records:
            return
        assert not info.state.is_final, info.reason


def children_of(pid: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def worker_of(lab: RunningExecutor) -> int:
    """The process of the only run."""
    [template] = children_of(lab.process.pid)
    [worker] = children_of(template)
    return worker


# ---------------------------------------------------------------- routers


@pytest.mark.more
async def test_a_restart_of_a_killed_router_only_costs_time(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    with ExitStack() as stack:
        router = stack.enter_context(router_process(endpoint))
        stack.enter_context(executor(tmp_path, connect=endpoint))
        async with seoro.Client(endpoint) as client:
            silent: list[float] = []
            back: list[float] = []
            run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=4)))
            run.executor.on_silence = lambda reason: silent.append(time.monotonic())
            run.executor.on_answer = lambda: back.append(time.monotonic())

            async def restart() -> None:
                await anyio.sleep(0.7)
                killed = time.monotonic()
                router.kill()
                await anyio.sleep(1.5)
                started = time.monotonic()
                await anyio.to_thread.run_sync(stack.enter_context, router_process(endpoint))
                with anyio.fail_after(DEADLINE):
                    while not back:
                        await anyio.sleep(0.05)
                measured(
                    f"router killed: noticed after {silent[0] - killed:.1f} s, asked again "
                    f"{back[0] - started:.1f} s after it was back"
                )

            async with anyio.create_task_group() as tasks:
                tasks.start_soon(restart)
                await follow(run)
            assert [each.id for each in await client.runs()] == [run.id]


@pytest.mark.more
async def test_a_frozen_router_only_costs_time(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    with router_process(endpoint) as router, executor(tmp_path, connect=endpoint):
        async with seoro.Client(endpoint) as client:
            run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=6)))
            await begun(run)
            router.send_signal(signal.SIGSTOP)
            await anyio.sleep(3.0)
            router.send_signal(signal.SIGCONT)
            await follow(run)


# ---------------------------------------------------------------- executors


@pytest.mark.more
async def test_a_frozen_executor_loses_no_run_and_its_runs_continue(tmp_path: Path) -> None:
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=6)))
            await begun(run)
            lab.process.send_signal(signal.SIGSTOP)
            await anyio.sleep(4.0)
            lab.process.send_signal(signal.SIGCONT)
            records = await follow(run)
    assert 5.9 < records[-1]["t"] < 6.1  # the run did not wait for it


@pytest.mark.more
def test_a_frozen_executor_does_not_hide_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    endpoint, file = free_endpoint(), write(tmp_path, HELLO)
    monkeypatch.setenv("SEORO_EXECUTOR", endpoint)
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    with (
        router_process(endpoint),
        executor(tmp_path / "a", name="lab-a", connect=endpoint) as frozen,
        executor(tmp_path / "b", name="lab-b", connect=endpoint),
    ):
        assert main(["exec", str(file), "--on", "lab-b"]) == 0
        frozen.process.send_signal(signal.SIGSTOP)
        capsys.readouterr()
        began = time.monotonic()
        assert main(["ps"]) == 3
        took = time.monotonic() - began
        out, err = capsys.readouterr()
        measured(f"executor frozen: `seoro ps` reported it after {took:.1f} s")
        assert "lab-b     passed" in out
        assert "note: the executor 'lab-a' does not answer; its runs are not listed" in err
        frozen.process.send_signal(signal.SIGCONT)


@pytest.mark.more
async def test_the_robots_of_a_run_stop_when_its_executor_is_killed(tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/rails"
    lab_file = tmp_path / "lab.yaml"
    lab_file.write_text(f"bridges:\n  floor: {{connect: {endpoint}}}\nrobots:\n  robot: {{in: floor, as: line}}\n")
    with rails_at(tmp_path, "--listen", endpoint, "line") as rails, executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            run = await client.submit(NAME, write(tmp_path, DRIVE), lab=seoro.Lab(lab_file))
            with anyio.fail_after(DEADLINE):
                while not rails.commands() or rails.commands()[-1][2] == 0.0:
                    await anyio.sleep(0.02)
            moment = time.monotonic()
            lab.kill()
            with anyio.fail_after(DEADLINE):
                while (took := rails.stopped_after(moment)) is None:
                    await anyio.sleep(0.02)
        measured(f"executor killed: its robot stopped after {took:.2f} s")
        assert took < 0.5
        with executor(tmp_path) as again:
            async with seoro.Client(again.endpoint) as client:
                assert (await client.run(run.id)).state is State.LOST


@pytest.mark.more
async def test_runs_continue_after_the_fork_server_is_killed(tmp_path: Path) -> None:
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=2)))
            await begun(run)
            [template] = children_of(lab.process.pid)
            os.kill(template, signal.SIGKILL)
            await follow(run)
            await follow(await client.submit(NAME, write(tmp_path, HELLO, "hello.osc")))


# ---------------------------------------------------------------- runs and simulators


@pytest.mark.more
async def test_a_frozen_process_of_a_run_resumes(tmp_path: Path) -> None:
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=6)))
            await begun(run)
            worker = worker_of(lab)
            os.kill(worker, signal.SIGSTOP)
            await anyio.sleep(2.0)
            os.kill(worker, signal.SIGCONT)
            await follow(run)


@pytest.fixture
def simulator(tmp_path: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """A simulator node that runs in real time, and its endpoint."""
    endpoint = f"unixsock-stream/{tmp_path}/sim"
    command = ("-m", "sim_nodes", "mujoco", "--listen", endpoint, "--world", "hall")
    with process(*command, says=None) as running:
        yield endpoint, running


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_a_killed_simulator_ends_its_run_as_an_error_and_the_next_run_starts(
    tmp_path: Path, simulator: tuple[str, subprocess.Popen[bytes]]
) -> None:
    endpoint, node = simulator
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            file = write(tmp_path, SIMULATED)
            run = await client.submit(NAME, file, simulator=seoro.Simulator(endpoint=endpoint, rate=1.0))
            waiting = await client.submit(NAME, write(tmp_path, HELLO, "hello.osc"))
            await begun(run)
            await anyio.sleep(0.5)
            killed = time.monotonic()
            node.kill()
            with anyio.fail_after(DEADLINE):
                verdict = await run.result()
            measured(f"simulator killed: the run ended after {time.monotonic() - killed:.1f} s: {verdict.reason}")
            assert verdict.status is seoro.RunStatus.ERROR
            check_sequence([record async for record in run.records()])
            await follow(waiting)


# ---------------------------------------------------------------- clients


@pytest.mark.more
async def test_a_client_killed_during_a_submission_causes_no_second_run(tmp_path: Path) -> None:
    file = write(tmp_path, HELLO)
    with executor(tmp_path, "--jobs", "2") as lab:
        command = [sys.executable, "-m", "seoro", "exec", str(file), "--on", NAME]
        command += ["--executor", lab.endpoint]
        for delay in (0.3, 0.4, 0.5, 0.6, 0.7):
            with subprocess.Popen(command, stdout=subprocess.DEVNULL) as running:
                await anyio.sleep(delay)
                running.kill()
        async with seoro.Client(lab.endpoint) as client:
            runs = await client.runs()
            assert len(runs) <= 5
            for run in runs:
                await follow(run)


@pytest.mark.more
async def test_a_run_stopped_while_the_executor_is_down_stays_stopped(tmp_path: Path) -> None:
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            run = await client.submit(NAME, write(tmp_path, LONG))
            await begun(run)
            lab.process.send_signal(signal.SIGSTOP)
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(run.stop, "enough")
                await anyio.sleep(1.0)
                lab.process.send_signal(signal.SIGCONT)
            with anyio.fail_after(DEADLINE):
                verdict = await run.result()
            assert (verdict.status, verdict.reason) == (seoro.RunStatus.CANCELLED, "enough")


@pytest.mark.more
async def test_a_client_gives_up_after_its_patience_and_finds_the_run_later(tmp_path: Path) -> None:
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint, patience=1.0) as client:
            run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=6)))
            await begun(run)
            lab.process.send_signal(signal.SIGSTOP)
            with anyio.fail_after(DEADLINE), pytest.raises(seoro.BackendError, match="does not answer"):
                await run.stop()
            lab.process.send_signal(signal.SIGCONT)
        async with seoro.Client(lab.endpoint) as client:
            found = await client.run(run.id)
            with anyio.fail_after(DEADLINE):
                check_sequence([record async for record in found.records()])
            assert found.state.is_final
