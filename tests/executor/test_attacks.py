"""Excessive messages and requests to an executor, a simulator or a bridge."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import MAX_FOLLOWING
from seoro.bridges.session import Refused, open_session
from seoro.bridges.wire import NAMESPACE, encode, executor_command
from seoro.bridges.wire.refusal import read_refusal
from tests.executors import LONG, NAME, executor

pytestmark = pytest.mark.anyio

ROOT = Path(__file__).parents[2]
DEADLINE = 30.0  # [s]


async def test_a_huge_array_is_refused_before_decoding(tmp_path: Path) -> None:
    size = 15_000_000
    payload = b"\xdd" + struct.pack(">I", size) + b"\x80" * size
    with executor(tmp_path) as running:
        before = peak(running.process.pid)
        async with open_session(connect=running.endpoint) as session:
            with pytest.raises(Refused) as caught:
                await session.query(executor_command(NAMESPACE, NAME, "describe"), payload, DEADLINE)
        assert "has 15000005 bytes; expected at most 65536" in read_refusal(caught.value.payload).message
        assert peak(running.process.pid) - before < 100.0


def peak(process: int) -> float:
    """Return the peak memory of a process [MB]."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * 1024 / 1e6


@pytest.mark.more
async def test_the_number_of_waiting_record_requests_is_limited(tmp_path: Path) -> None:
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    codes: list[int] = []
    with executor(tmp_path) as running:
        async with seoro.Client(running.endpoint) as client, open_session(connect=running.endpoint) as session:
            run = await client.submit(NAME, file)
            async for info, _ in run.parts():
                if info.announcement:
                    break
            key = executor_command(NAMESPACE, NAME, wire.RECORDS.name)
            asked = wire.AskRecords(run=run.id, state=wire.State.RUNNING, is_announced=True, at=1 << 40, wait=10.0)

            async def ask() -> None:
                try:
                    await session.query(key, encode(asked), DEADLINE)
                except Refused as refused:
                    codes.append(read_refusal(refused.payload).code)

            async with anyio.create_task_group() as tasks:
                for _ in range(MAX_FOLLOWING + 100):
                    tasks.start_soon(ask)
                with anyio.fail_after(DEADLINE):
                    while len(codes) < 100:
                        await anyio.sleep(0.01)
                    assert [each.id for each in await client.runs()] == [run.id]
                    await run.stop()
    assert set(codes) == {wire.UNAVAILABLE}


@pytest.mark.slow
@pytest.mark.parametrize("target", ["executor", "keyed-executor", "keyed-simulator", "bridge"])
def test_an_emergency_stop_takes_effect_during_attacks(target: str) -> None:
    script = ROOT / "benchmarks" / "emergency_attacks.py"
    command = [sys.executable, str(script), "--targets", target, "--tries", "3"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
