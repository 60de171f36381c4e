"""Acknowledged changes of an executor survive a loss of power, and no run is executed twice.

The simulated disk contains only synchronised data: other contents and folder entries are lost. All other parts
are real: files, SQLite, and executors that start with the remaining files.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.client.runs import RemoteRun
from seoro.executor.process.frames import Frame
from seoro.executor.process.pool import Worker
from seoro.executor.service import ExecutorOptions, open_executor
from seoro.executor.storage.store import Store
from tests.executors import HELLO, LONG
from tests.labs import NAME, free_port, make_lab

pytestmark = pytest.mark.anyio

DEADLINE = 60.0  # [s]
FULL = 2  # SQLite forces each transaction to the disk
PRINTING = "import osc.helpers\nimport osc.mine\nscenario main:\n    do serial:\n        say()\n"


@dataclass
class Disk:
    """Synchronised content of a folder on a disk, by inode numbers: contents and entries."""

    folder: Path
    contents: dict[int, bytes] = field(default_factory=dict)
    entries: dict[int, dict[str, tuple[int, bool]]] = field(default_factory=dict)  # with whether each is a folder

    def force(self, descriptor: int) -> None:
        """Record the effect of `fsync`."""
        found = os.fstat(descriptor)
        path = _path(descriptor)
        if not stat.S_ISDIR(found.st_mode):
            self.contents[found.st_ino] = path.read_bytes()
            return
        with os.scandir(path) as entries:
            self.entries[found.st_ino] = {
                each.name: (each.inode(), each.is_dir(follow_symlinks=False)) for each in entries
            }

    def force_database(self) -> None:
        """Follow what SQLite does at the end of a transaction; it also makes its files last by their names."""
        entries = self.entries.setdefault(self.folder.stat().st_ino, {})
        for name in ("runs.sqlite", "runs.sqlite-wal"):
            path = self.folder / name
            if path.exists():
                self.contents[path.stat().st_ino] = path.read_bytes()
                entries[name] = path.stat().st_ino, False

    def left(self, to: Path) -> None:
        """Create a folder with the content after a power failure at this time."""
        self._make(self.folder.stat().st_ino, to)

    def _make(self, number: int, to: Path) -> None:
        to.mkdir()
        for name, (inside, is_folder) in self.entries.get(number, {}).items():
            if is_folder:
                self._make(inside, to / name)
            else:
                (to / name).write_bytes(self.contents.get(inside, b""))


@pytest.fixture
def disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Disk:
    made = Disk(tmp_path / "state")
    for name in ("fsync", "fdatasync"):
        monkeypatch.setattr(os, name, _followed(getattr(os, name), made.force))
    do = Store._do

    async def do_followed(store: Store, work: Callable[..., Any]) -> Any:
        result = await do(store, work)
        if await do(store, lambda database: database.execute("PRAGMA synchronous").fetchone()[0]) == FULL:
            made.force_database()
        return result

    monkeypatch.setattr(Store, "_do", do_followed)
    return made


def _followed(call: Callable[[int], None], follow: Callable[[int], None]) -> Callable[[int], None]:
    def carry_out(descriptor: int) -> None:
        call(descriptor)
        if _path(descriptor).is_absolute():
            follow(descriptor)

    return carry_out


def _path(descriptor: int) -> Path:
    return Path(f"/proc/self/fd/{descriptor}").readlink()


def options(folder: Path, place: Path, **others: Any) -> ExecutorOptions:
    return ExecutorOptions(NAME, folder, **{"listen": f"unixsock-stream/{place}/hub", **others})


async def messages(run: RemoteRun) -> list[str]:
    return [record["message"] async for record in run.records_so_far() if record["kind"] == "log"]


async def until_begun(run: RemoteRun) -> None:
    async for record in run.records():
        if record.get("message") == "begun":
            return


async def test_an_accepted_run_is_executed_after_a_power_failure(tmp_path: Path, disk: Disk) -> None:
    """The disk contains all files of its bundle."""
    long, hello, left = tmp_path / "long.osc", tmp_path / "hello.osc", tmp_path / "left"
    long.write_text(LONG)
    (tmp_path / "other.osc").write_text("struct unused\n")
    hello.write_text(HELLO.replace("\n", '\nimport "other.osc"\n', 1))
    with anyio.fail_after(DEADLINE):
        made = options(disk.folder, tmp_path)
        async with open_executor(made), seoro.Client(made.listen) as client:
            await until_begun(await client.submit(NAME, long))
            waiting = await client.submit(NAME, hello)
            disk.left(left)
        made = options(left, tmp_path)
        async with open_executor(made), seoro.Client(made.listen) as client:
            assert {run.info.file: run.state for run in await client.runs()}[str(long)] is State.LOST
            run = await client.run(waiting.id)
            assert (await run.result()).passed
            assert await messages(run) == ["hello"]


@pytest.mark.more
async def test_a_started_run_is_not_repeated_after_a_power_failure(
    tmp_path: Path, disk: Disk, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, left, send = tmp_path / "hello.osc", tmp_path / "left", Worker.send
    file.write_text(HELLO)

    def send_after_loss(worker: Worker, kind: Frame, data: bytes = b"") -> None:
        if not left.exists():
            disk.left(left)
        send(worker, kind, data)

    monkeypatch.setattr(Worker, "send", send_after_loss)
    with anyio.fail_after(DEADLINE):
        made = options(disk.folder, tmp_path)
        async with open_executor(made), seoro.Client(made.listen) as client:
            run = await client.submit(NAME, file)
            assert (await run.result()).passed
        made = options(left, tmp_path)
        async with open_executor(made), seoro.Client(made.listen) as client:
            again = await client.run(run.id)
            assert again.state is State.LOST
            assert await messages(again) == []


@pytest.mark.more
async def test_the_outcome_of_a_run_survives_a_power_failure(tmp_path: Path, disk: Disk) -> None:
    """It includes the trace, the printed output and the audit log."""
    lab, left, port = make_lab(tmp_path / "lab"), tmp_path / "left", free_port()
    file, libraries = tmp_path / "main.osc", tmp_path / "seoro.libraries"
    libraries.mkdir()
    file.write_text(PRINTING)
    (libraries / "mine.osc").write_text("action say\n")
    (libraries / "mine.py").write_text(
        "from seoro import ActionContext, action\n\n"
        '@action("say")\nasync def say(ctx: ActionContext) -> None:\n    print("printed")\n'
    )
    others = {"listen": f"tls/127.0.0.1:{port}", "keys": lab.keys(NAME), "allowed": frozenset({"python"})}
    with anyio.fail_after(DEADLINE):
        made = options(disk.folder, tmp_path, **others)
        async with open_executor(made), seoro.Client(made.listen, lab.keys("anna")) as client:
            run = await client.submit(NAME, file)
            records = [record async for record in run.records()]
            assert (await run.result()).passed
            disk.left(left)
        lines = [json.loads(line) for line in (left / "audit.jsonl").read_bytes().splitlines()]
        outcomes = [(line["what"], line.get("outcome")) for line in lines if line.get("run") == run.id]
        assert ("submit", "taken") in outcomes
        assert ("run", "passed") in outcomes
        made = options(left, tmp_path, **others)
        async with open_executor(made), seoro.Client(made.listen, lab.keys("anna")) as client:
            again = await client.run(run.id)
            assert (await again.result()).passed
            assert [record async for record in again.records()] == records
            [printed] = await again.fetch(tmp_path / "out")
            assert printed.read_text() == "printed\n"


@pytest.mark.more
async def test_an_emergency_stop_survives_a_power_failure(tmp_path: Path, disk: Disk) -> None:
    left = tmp_path / "left"
    with anyio.fail_after(DEADLINE):
        made = options(disk.folder, tmp_path)
        async with open_executor(made), seoro.Client(made.listen) as client:
            await client.lab().stop_all("smoke")
            disk.left(left)
        made = options(left, tmp_path)
        async with open_executor(made), seoro.Client(made.listen) as client:
            [status] = await client.describe()
            assert "smoke" in status.info.stopped
