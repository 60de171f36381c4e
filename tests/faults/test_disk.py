"""A disk that is full at the executor: a real one, small, where a test may mount it."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from tests.executors import HELLO, LONG, NAME, RunningExecutor, executor
from tests.faults.checks import DEADLINE, check_sequence, follow

MUCH = """import osc.helpers
scenario much:
    event tick
    on every(10ms):
        emit tick
    do serial:
        wait elapsed(300s)
"""


@pytest.fixture
def small(tmp_path: Path) -> Iterator[RunningExecutor]:
    """An executor whose runs are on a disk of 3 MiB."""
    yield from on_disk(tmp_path, 3)


@pytest.fixture
def keeping(tmp_path: Path) -> Iterator[RunningExecutor]:
    """An executor whose runs are on a disk of 12 MiB, of which it keeps 4."""
    policy = tmp_path / "policy.yaml"
    policy.write_text("everybody: {free: 4, allow: [python]}\n")
    yield from on_disk(tmp_path, 12, "--policy", str(policy), "--jobs", "2")


def on_disk(folder: Path, size: int, *options: str) -> Iterator[RunningExecutor]:
    """An executor with a disk of its own [MiB]."""
    state = folder / "state"
    state.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}m", "tmpfs", str(state)]
    mounted = subprocess.run(command, check=False, capture_output=True, text=True)
    if mounted.returncode != 0:
        pytest.skip(f"nothing can be mounted here: {mounted.stderr.strip()}")
    try:
        with executor(folder, *options) as running:
            yield running
    finally:
        subprocess.run(["umount", "--lazy", str(state)], check=True)


@pytest.mark.more
async def test_a_trace_that_fills_the_disk_ends_its_run_and_no_other(
    small: RunningExecutor, tmp_path: Path
) -> None:
    much, hello = tmp_path / "much.osc", tmp_path / "hello.osc"
    much.write_text(MUCH)
    hello.write_text(HELLO)
    async with seoro.Client(small.endpoint) as client:
        before = await client.submit(NAME, hello)
        await follow(before)
        run = await client.submit(NAME, much, clock="virtual")
        with anyio.fail_after(DEADLINE):
            async for info, _ in run.parts():
                state = info.state
        assert state is State.ERROR
        assert "this run has written most" in run.info.reason
        check_sequence([record async for record in run.records()])
        assert (await client.run(before.id)).state is State.PASSED
        await follow(await client.submit(NAME, hello))  # there is space again
        assert len(await client.runs()) == 3


@pytest.mark.more
async def test_a_client_that_fills_the_disk_with_bundles_is_refused(
    small: RunningExecutor, tmp_path: Path
) -> None:
    folder = tmp_path / "models"
    folder.mkdir()
    (folder / "large.bin").write_bytes(bytes(4 << 20))
    hello = tmp_path / "hello.osc"
    hello.write_text(HELLO)
    async with seoro.Client(small.endpoint) as client:
        with pytest.raises(seoro.BackendError, match=r"its disk has .* left"):
            await client.submit(NAME, hello, simulator=seoro.Simulator(name="mujoco", model_path=[folder]))
        assert await client.runs() == []
        await follow(await client.submit(NAME, hello))


@pytest.mark.more
async def test_runs_leave_the_reserve_of_the_executor_free(keeping: RunningExecutor, tmp_path: Path) -> None:
    much, long, hello = tmp_path / "much.osc", tmp_path / "long.osc", tmp_path / "hello.osc"
    much.write_text(MUCH)
    long.write_text(LONG)
    hello.write_text(HELLO)
    least = keeping.folder / "state"
    async with seoro.Client(keeping.endpoint) as client:
        innocent = await client.submit(NAME, long)
        run = await client.submit(NAME, much, clock="virtual")
        lowest = shutil.disk_usage(least).free
        with anyio.fail_after(DEADLINE):
            async for info, _ in run.parts():
                state = info.state
                lowest = min(lowest, shutil.disk_usage(least).free)
        assert state is State.ERROR
        assert "4.0 MiB have to stay free" in run.info.reason
        assert "`free`" in run.info.reason
        assert lowest > 1 << 20  # traces leave 2 MiB, half of the reserve; the ends of runs take some of it
        # The next run is accepted without a manual clean-up, and only the culprit has ended.
        await follow(await client.submit(NAME, hello))
        assert (await client.run(innocent.id)).state is State.RUNNING
        await innocent.stop()
