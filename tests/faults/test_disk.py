"""A disk that is full at the executor: a real one, small, where a test may mount it."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from tests.executors import HELLO, NAME, RunningExecutor, executor
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
    folder = tmp_path / "state"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(folder)]
    mounted = subprocess.run(command, check=False, capture_output=True, text=True)
    if mounted.returncode != 0:
        pytest.skip(f"nothing can be mounted here: {mounted.stderr.strip()}")
    try:
        with executor(tmp_path) as running:
            yield running
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


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
        assert "No space left on device" in run.info.reason
        check_sequence([record async for record in run.records()])
        assert (await client.run(before.id)).state is State.PASSED
        with pytest.raises(seoro.BackendError, match=r"its disk has .* left"):
            await client.submit(NAME, hello, clock="virtual")
        await run.remove()  # which makes room
        await follow(await client.submit(NAME, hello))
        assert len(await client.runs()) == 2


async def test_who_fills_the_disk_with_bundles_is_told(small: RunningExecutor, tmp_path: Path) -> None:
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
