"""An executor in the process of the test, with cases that take long in another process."""

import errno
import math
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import State
from seoro.embed.video import VideoOptions
from seoro.errors import BackendRefused
from seoro.executor.job import Job, make_job
from seoro.executor.runs import active_run as live_runs
from seoro.executor.runs import ends, queue
from seoro.executor.service import ExecutorOptions, open_executor
from seoro.executor.storage.store import Finished, Store, open_store
from seoro.runtime.verdict import RunStatus
from tests.executors import HELLO
from tests.sim_nodes.engines import needs_pictures

HANGING = """import time

from seoro import ActionContext, action

@action("hang")
async def hang(ctx: ActionContext) -> None:
    ctx.log("hanging")
    while True:
        time.sleep(0.1)
"""
SCENARIO = """import osc.helpers
import osc.mine
scenario main:
    do serial:
        log("begun")
        hang()
"""


DEADLINE = 30.0  # [s]


def submission(run: str) -> wire.Submission:
    file = wire.BundleFile(path="main.osc", hash="0" * 64, size=1)
    options = wire.BundledOptions(grace=5.0, overrides={})
    manifest = wire.Manifest(files=(file,), entry="main.osc", shown="main.osc", options=options)
    return wire.Submission(run=run, manifest=manifest)


@pytest.fixture
def hanging(tmp_path: Path) -> Path:
    """Write a scenario that blocks its process endlessly."""
    folder = tmp_path / "seoro.libraries"
    folder.mkdir()
    (folder / "mine.osc").write_text("action hang\n")
    (folder / "mine.py").write_text(HANGING)
    file = tmp_path / "hanging.osc"
    file.write_text(SCENARIO)
    return file


async def test_a_run_that_ignores_its_stop_is_killed(
    tmp_path: Path, hanging: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_runs, "STOP_TIMEOUT", 0.5)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    options = ExecutorOptions("lab-a", tmp_path / "state", listen=endpoint, allowed=frozenset({"python"}))
    async with open_executor(options), seoro.Client(endpoint) as client:
        run = await client.submit("lab-a", hanging)
        async for record in run.records():
            if record["kind"] == "log":
                break
        await run.stop()
        with anyio.fail_after(30.0), pytest.raises(seoro.BackendError, match="was killed"):
            await run.result()
        assert run.state is State.ERROR


async def test_old_runs_are_removed(tmp_path: Path, hanging: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    options = ExecutorOptions("lab-a", tmp_path / "state", listen=endpoint)
    async with open_executor(options), seoro.Client(endpoint) as client:
        run = await client.submit("lab-a", hanging)
        with pytest.raises(seoro.InvalidScenario):  # Python is not allowed
            await run.result()
    options = ExecutorOptions("lab-a", tmp_path / "state", listen=endpoint, keep=1e-9)
    async with open_executor(options), seoro.Client(endpoint) as client:
        with anyio.fail_after(30.0):
            while await client.runs():
                await anyio.sleep(0.02)
    assert list((tmp_path / "state" / "runs").iterdir()) == []
    assert list((tmp_path / "state" / "blobs").iterdir()) == []


@pytest.mark.more
async def test_a_run_that_cannot_be_removed_delays_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stuck, other = "0" * 32, "1" * 32
    with open_store(tmp_path / "state") as store:
        for run in (stuck, other):
            await store.add(submission(run))
            store.folder(run).files.mkdir(parents=True)
            await store.finish(run, Finished(State.PASSED, "", b"", 1.0))
        (store.blobs / ("a" * 64)).write_text("old")
    rmtree = shutil.rmtree

    def refuse(path: Path) -> None:
        if path.name == stuck:
            raise OSError(errno.EBUSY, "Device or resource busy", str(path))
        rmtree(path)

    monkeypatch.setattr("seoro.executor.storage.store.shutil.rmtree", refuse)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    options = ExecutorOptions("lab-a", tmp_path / "state", listen=endpoint, keep=1e-9)
    async with open_executor(options), seoro.Client(endpoint) as client:
        with anyio.fail_after(DEADLINE):
            while len(runs := await client.runs()) > 1 or any((tmp_path / "state" / "blobs").iterdir()):
                await anyio.sleep(0.02)
        assert [run.id for run in runs] == [stuck]
        with pytest.raises(BackendRefused, match="Device or resource busy"):
            await runs[0].remove()


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_an_unwritable_video_makes_the_run_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs_pictures("mujoco")
    pytest.importorskip("av", reason="PyAV is not installed")
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)

    def filled(*given: Any, **options: Any) -> Job:
        found = make_job(*given, **options)
        Path(found.output, "video.mp4").symlink_to("/dev/full")
        return found

    monkeypatch.setattr(queue, "make_job", filled)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    options = ExecutorOptions("lab-a", tmp_path / "state", listen=endpoint)
    async with open_executor(options), seoro.Client(endpoint) as client:
        simulator = seoro.Simulator(name="mujoco", world="empty")
        film = VideoOptions(width=64, height=48, rate=1)
        run = await client.submit("lab-a", file, simulator=simulator, film=film)
        with anyio.fail_after(60.0):
            verdict = await run.result()
        assert (run.state, verdict.status) == (State.ERROR, RunStatus.ERROR)
        assert verdict.reason == "the video ends early: No space left on device; the run itself: passed"


@pytest.mark.more
@pytest.mark.parametrize("is_mended", [True, False])
async def test_an_unwritable_database_does_not_end_the_executor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_mended: bool
) -> None:
    monkeypatch.setattr(ends, "KEEP_PAUSE", 0.05)
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    options = ExecutorOptions("lab-a", tmp_path / "state", listen=endpoint)

    finish, refused = Store.finish, set[str]()

    async def refuse(store: Store, run: str, how: Finished) -> None:
        if not refused or run in refused:
            refused.add(run)
            raise sqlite3.OperationalError("database or disk is full")
        await finish(store, run, how)

    async with open_executor(options), seoro.Client(endpoint) as client:
        monkeypatch.setattr(Store, "finish", refuse)
        run = await client.submit("lab-a", file)
        with anyio.fail_after(30.0):
            async for info, _ in run.parts():
                state = info.state
        assert state is State.PASSED  # watchers receive it, though it cannot be stored
        assert (await client.run(run.id)).state is State.PASSED
        other = await client.submit("lab-a", file)
        with anyio.fail_after(30.0):
            assert (await other.result()).passed
        if is_mended:
            monkeypatch.setattr(Store, "finish", finish)
            await anyio.sleep(0.2)
    async with open_executor(options), seoro.Client(endpoint) as client:
        assert (await client.run(run.id)).state is (State.PASSED if is_mended else State.LOST)


async def test_an_invalid_stored_submission_is_an_error_of_its_run(tmp_path: Path) -> None:
    waited, ran = "0" * 32, "1" * 32
    with open_store(tmp_path / "state") as store:
        for run in (waited, ran):
            await store.add(submission(run).model_copy(update={"stop_if_lost": math.nan}))
        await store.start(ran)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    options = ExecutorOptions("lab-a", tmp_path / "state", listen=endpoint)
    async with open_executor(options) as started, seoro.Client(endpoint) as client:
        assert started.lost == 1
        assert (await client.run(ran)).state is State.LOST
        found = await client.run(waited)
        assert found.state is State.ERROR
        with pytest.raises(seoro.BackendError, match="cannot read the stored submission"):
            await found.result()
