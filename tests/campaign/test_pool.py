"""Slots of the pool whose simulator or worker does not start, or is killed."""

import asyncio
import os
import signal
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import cast

import pytest

import seoro.campaign
from seoro.campaign.asking import CampaignFields
from seoro.campaign.engine import Killed, NotBegun, WorkerDied
from seoro.campaign.pool import pool
from seoro.campaign.pool.simulators import Node
from seoro.campaign.runs import End, Planned
from seoro.campaign.store.folder import read_campaign
from seoro.concurrency.forks.using import Forked, Forks, NoProcess
from seoro.errors import BackendError
from tests.campaign.generated import generate
from tests.campaign.test_campaigns import parents_of, processes_of


async def test_a_simulator_that_started_before_is_started_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    works = iter([False, True, False, False, True, False, False, False])

    @asynccontextmanager
    async def node(_name: str) -> AsyncIterator[Node]:
        if not next(works):
            raise BackendError("no memory")
        yield Node("", cast(asyncio.subprocess.Process, None), deque())

    monkeypatch.setattr(pool, "simulator_node", node)
    generate(tmp_path, 0)
    slot = pool._Slot(read_campaign(tmp_path), tmp_path, cast(Forks, None), "w")
    with pytest.raises(BackendError):  # for the first time
        await slot._start_simulator("mujoco")
    await slot._start_simulator("mujoco")
    slot._count = 1
    for expected in (NotBegun, NotBegun, None, NotBegun, NotBegun, BackendError):
        if expected is None:
            await slot._start_simulator("mujoco")
        else:
            with pytest.raises(expected, match="no memory"):
                await slot._start_simulator("mujoco")


class NoForks:
    """Fork server that does not work."""

    async def fork(self) -> Forked:
        """Fork no process."""
        raise NoProcess("killed")


async def test_a_worker_that_started_before_is_started_again(tmp_path: Path) -> None:
    generate(tmp_path, 0)
    slot = pool._Slot(read_campaign(tmp_path), tmp_path, cast(Forks, NoForks()), "w")
    with pytest.raises(BackendError, match="no worker can be started: killed"):  # for the first time
        await slot._fork()
    slot._count, slot._failed_forks = 1, 0
    for expected in (NotBegun, NotBegun, BackendError):
        with pytest.raises(expected, match="killed"):
            await slot._fork()


@pytest.mark.parametrize(
    ("status", "kind", "text"),
    [
        (-signal.SIGKILL, Killed, "the process of the run was killed by SIGKILL"),
        (-signal.SIGSEGV, WorkerDied, "the run ended its process by SIGSEGV: at 0"),
        (3, WorkerDied, "the run ended its process with status 3: at 0"),
        (None, Killed, "the worker died with its fork server"),
    ],
)
def test_a_kill_is_no_crash(status: int | None, kind: type[WorkerDied], text: str) -> None:
    died = pool._death("the run", status, "at 0")
    assert (type(died), str(died)) == (kind, text)


@pytest.mark.parametrize("is_started_anew", [True])
async def test_a_killed_fork_server_is_replaced(tmp_path: Path) -> None:
    file, folder = tmp_path / "main.osc", tmp_path / "out"
    file.write_text("import osc.helpers\nscenario main:\n    do log('x')\n")
    arguments: CampaignFields = {"clock": "virtual", "repeat": 2, "isolation": "run", "folder": folder}
    async with seoro.campaign.start(file, **arguments) as campaign:
        await campaign.wait()
    ends = []
    async with pool.open_pool(read_campaign(folder), folder, 1) as opened:
        for number in (3, 4):
            planned = Planned(number, number, 1, 7, {}, "grid")
            ends += [(row.run, row.status) async for row in opened.run([planned])]
            (server,) = (each for each in processes_of(str(folder)) if next(parents_of(each)) == os.getpid())
            os.kill(int(server), signal.SIGKILL)
    assert ends == [(3, End.PASSED), (4, End.PASSED)]
