"""The processes of runs: each has one of its own, and one that dies is no loss to the next."""

import os
import signal
from collections.abc import AsyncIterator
from io import BytesIO
from pathlib import Path

import pytest

from seoro.bridges.executor import messages as wire
from seoro.embed.ends import Ended, unpack_end
from seoro.executor.frames import Frame, Job
from seoro.executor.worker import Orders
from seoro.executor.workers import Pool, Worker, open_pool
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
    worker.begin(job(folder))
    frames = [frame async for frame in worker.frames()]
    assert frames[-1][0] is Frame.END
    worker.close()
    assert await worker.wait() == 0
    end = unpack_end(frames[-1][1])
    assert isinstance(end, Ended)
    return end


async def test_runs_have_processes_of_their_own(pool: Pool, tmp_path: Path) -> None:
    first, second = await pool.take(), await pool.take()
    for number, worker in enumerate((first, second)):
        assert (await carry_out(worker, tmp_path / str(number))).verdict.passed


async def test_how_a_process_ended_is_known(pool: Pool) -> None:
    worker = await pool.take()
    worker.kill()
    assert [frame async for frame in worker.frames()] == []
    assert await worker.wait() == -signal.SIGKILL
    worker.close()


async def test_a_process_without_a_job_ends_with_its_executor(pool: Pool) -> None:
    worker = await pool.take()
    worker.close()
    assert await worker.wait() == 0


async def test_when_what_makes_processes_has_died_runs_go_on_and_more_are_made(pool: Pool, tmp_path: Path) -> None:
    worker = await pool.take()
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    [template] = [each for each in children if b"template" in Path(f"/proc/{each}/cmdline").read_bytes()]
    os.kill(int(template), signal.SIGKILL)
    worker.begin(job(tmp_path / "first"))
    frames = [frame async for frame in worker.frames()]
    assert frames[-1][0] is Frame.END
    assert await worker.wait() is None  # there is nobody who could tell
    worker.close()
    assert (await carry_out(await pool.take(), tmp_path / "second")).verdict.passed


def test_a_run_that_is_over_is_asked_for_nothing() -> None:
    asked: list[str] = []
    orders = Orders(BytesIO())
    orders.when_asked(asked.append, asked.append)
    orders.end()
    orders.ask("the executor is gone", Frame.HALT)
    assert asked == []
