"""Dry runs, one at a time, independent of other clients."""

from pathlib import Path
from typing import Any, cast

import anyio
import anyio.from_thread
import anyio.lowlevel
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bundle.unpack import check_manifest
from seoro.executor.runs.dry_run import DryRuns
from seoro.executor.service import ExecutorOptions, open_executor
from seoro.executor.storage import intake
from tests.executors import HELLO, NAME

DEADLINE = 30.0  # [s]


def test_a_second_dry_run_is_refused_until_later() -> None:
    dry_runs = DryRuns(cast("Any", None))
    with dry_runs.one(), pytest.raises(RequestRefused) as refused, dry_runs.one():
        pass
    assert refused.value.code == wire.UNAVAILABLE
    with dry_runs.one():
        pass


@pytest.fixture
def hello(tmp_path: Path) -> Path:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    return file


@pytest.fixture
def options(tmp_path: Path) -> ExecutorOptions:
    return ExecutorOptions(NAME, tmp_path / "state", listen=f"unixsock-stream/{tmp_path}/hub")


async def test_the_end_of_a_dry_run_spares_files_of_a_submission(
    options: ExecutorOptions, hello: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, ends, checked = anyio.Event(), anyio.Event(), list[str]()

    async def wait(*_: object) -> wire.DryRunResult:
        begun.set()
        await ends.wait()
        return wire.DryRunResult(seed=7, parameters=b"{}")

    async def end() -> None:
        ends.set()
        for _ in range(20):
            await anyio.lowlevel.checkpoint()

    def check_while_one_ends(manifest: wire.Manifest) -> None:
        check_manifest(manifest)
        checked.append(manifest.shown)
        if begun.is_set():
            anyio.from_thread.run(end)

    monkeypatch.setattr(DryRuns, "execute", wait)
    monkeypatch.setattr(intake, "check_manifest", check_while_one_ends)
    blobs = options.folder / "blobs"
    async with open_executor(options), seoro.Client(options.listen) as client:
        with anyio.fail_after(DEADLINE):
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(client.dry_run, NAME, hello)
                await begun.wait()
                await client.submit(NAME, hello)
        assert len(checked) == 2  # it had all files at once
        assert list(blobs.iterdir()) == []


async def test_files_removed_during_unpacking_are_sent_again(
    options: ExecutorOptions, hello: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = list[str]()

    def lose_one(manifest: wire.Manifest) -> None:
        check_manifest(manifest)
        if not gone:
            gone.append(manifest.files[0].hash)
            (options.folder / "blobs" / gone[0]).unlink()

    monkeypatch.setattr(intake, "check_manifest", lose_one)
    async with open_executor(options), seoro.Client(options.listen) as client:
        await client.submit(NAME, hello)
    assert len(gone) == 1
