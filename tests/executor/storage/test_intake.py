"""Intake of bundles, which does not delay other clients."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bundle.unpack import unpack
from seoro.executor.service import ExecutorOptions, open_executor
from seoro.executor.storage import intake
from tests.executors import HELLO, NAME

pytestmark = pytest.mark.anyio

DEADLINE = 60.0  # [s]


async def test_a_submission_does_not_wait_for_the_bundle_of_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    large, small = tmp_path / "large.osc", tmp_path / "small.osc"
    large.write_text(HELLO)
    small.write_text(HELLO + "# another\n")
    begun, goes_on = threading.Event(), threading.Event()

    def unpack_slowly(manifest: wire.Manifest, blob: Callable[[str], Path], folder: Path) -> None:
        if manifest.shown == str(large):
            begun.set()
            assert goes_on.wait(DEADLINE)
        unpack(manifest, blob, folder)

    monkeypatch.setattr(intake, "unpack", unpack_slowly)
    options = ExecutorOptions(NAME, tmp_path / "state", listen=f"unixsock-stream/{tmp_path}/hub")
    with anyio.fail_after(DEADLINE):
        async with open_executor(options), seoro.Client(options.listen) as client:
            try:
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(client.submit, NAME, large)
                    await anyio.to_thread.run_sync(begun.wait, DEADLINE)
                    assert (await (await client.submit(NAME, small)).result()).passed
                    goes_on.set()
            finally:
                goes_on.set()
            assert len(await client.runs()) == 2


def test_files_of_equal_content_are_one_copy(tmp_path: Path) -> None:
    """The copy is independent of the blob, so a run may change its files."""
    digest = "2d711642b726b04401627ca9fbac32f5c8530fb1903cc4db02258717921a4881"  # of "x"
    blob, size = tmp_path / "blob", 1
    blob.write_text("x")
    files = tuple(wire.BundleFile(path=f"{number}/a.osc", hash=digest, size=size) for number in range(3))
    manifest = wire.Manifest(
        files=files, entry="0/a.osc", shown="a.osc", options=wire.BundledOptions(grace=5.0, overrides={})
    )
    unpack(manifest, lambda _: blob, tmp_path / "files")
    numbers = {path.stat().st_ino for path in (tmp_path / "files").glob("*/a.osc")}
    assert len(numbers) == 1
    assert blob.stat().st_ino not in numbers
