"""Processes of runs: each run has its own, and survives the death of others."""

import os
import signal
from collections.abc import AsyncIterator
from io import BytesIO
from pathlib import Path

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import encode
from seoro.embed.run_end import Ended, unpack_end
from seoro.executor.job import Job
from seoro.executor.process.control import Control
from seoro.executor.process.frames import Frame
from seoro.executor.process.pool import Pool, Worker, open_pool
from tests.executors import HELLO


@pytest.fixture
async def pool() -> AsyncIterator[Pool]:
    async with open_pool(dict(os.environ)) as opened:
        yield opened


def job(folder: Path) -> Job:
    folder.mkdir()
    (folder / "hello.osc").write_text(HELLO)
    file = wire.BundleFile(path="hello.osc", hash="0" * 64, size=len(HELLO))
    options = wire.BundledOptions(grace=5.0, overrides={})
    manifest = wire.Manifest(files=(file,), entry="hello.osc", shown="hello.osc", options=options)
    place = str(folder)
    return Job(
        manifest=manifest,
        files=place,
        output=place,
        log=f"{place}/log.txt",
        home=place,
        largest_file=1 << 30,
        allowed=(),
    )


async def carry_out(worker: Worker, folder: Path) -> Ended:
    worker.send(Frame.JOB, encode(job(folder)))
    frames = [frame async for frame in worker.frames()]
    assert frames[-1][0] is Frame.END
    worker.close()
    assert await worker.wait() == 0
    end = unpack_end(frames[-1][1])
    assert isinstance(end, Ended)
    return end


def parent_of(process: int) -> int:
    return int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])


async def test_a_process_may_have_a_python_of_its_own(pool: Pool, tmp_path: Path) -> None:
    parents = []
    for number, has_own_python in enumerate((False, False, True, True)):
        async with pool.process(has_own_python=has_own_python) as worker:
            parents.append(parent_of(worker.process))
            assert (await carry_out(worker, tmp_path / str(number))).verdict.passed
    assert parents[0] == parents[1] and len(set(parents)) == 3
    assert not any(Path(f"/proc/{parent}").exists() for parent in parents[2:])


async def test_each_run_has_its_own_process(pool: Pool, tmp_path: Path) -> None:
    first, second = await pool.acquire(), await pool.acquire()
    for number, worker in enumerate((first, second)):
        assert (await carry_out(worker, tmp_path / str(number))).verdict.passed


async def test_the_exit_status_of_a_process_is_known(pool: Pool) -> None:
    worker = await pool.acquire()
    worker.kill()
    assert [frame async for frame in worker.frames()] == []
    assert await worker.wait() == -signal.SIGKILL
    worker.close()


async def test_a_process_without_a_job_ends_with_its_executor(pool: Pool) -> None:
    worker = await pool.acquire()
    worker.close()
    assert await worker.wait() == 0


async def test_the_death_of_the_fork_server_spares_runs_and_it_is_restarted(pool: Pool, tmp_path: Path) -> None:
    worker = await pool.acquire()
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    [fork_server] = [each for each in children if b"fork_server" in Path(f"/proc/{each}/cmdline").read_bytes()]
    os.kill(int(fork_server), signal.SIGKILL)
    worker.send(Frame.JOB, encode(job(tmp_path / "first")))
    frames = [frame async for frame in worker.frames()]
    assert frames[-1][0] is Frame.END
    assert await worker.wait() is None  # its parent is dead
    worker.close()
    assert (await carry_out(await pool.acquire(), tmp_path / "second")).verdict.passed


def test_a_detached_run_receives_no_requests() -> None:
    received: list[Frame] = []
    requests = Control(BytesIO())
    requests.on_end(lambda kind, _reason: received.append(kind))
    requests.detach()
    requests.end(Frame.HALT, "the executor has died")
    assert received == []


def test_a_run_receives_earlier_requests_once() -> None:
    received: list[tuple[Frame, str]] = []
    requests = Control(BytesIO())
    for kind, reason in ((Frame.STOP, "first"), (Frame.ABORT, "second"), (Frame.HALT, "third")):
        requests.end(kind, reason)
    requests.on_end(lambda kind, reason: received.append((kind, reason)))
    assert received == [(Frame.STOP, "first"), (Frame.HALT, "third")]
