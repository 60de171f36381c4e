"""Tasks on Dask workers: chunks of runs of a campaign, in a pool that the chunks of a worker share.

Dask sends functions and values by pickle, so the machines of a cluster have to trust each other.
"""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import AsyncExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple, Self

import distributed

from seoro import __version__
from seoro.bundle.paths import check_path
from seoro.campaign.engine import Killed, WorkerDied
from seoro.campaign.pool.pool import Pool, open_pool
from seoro.campaign.runs import Planned
from seoro.campaign.store.folder import RUNS, CampaignFile, write_campaign
from seoro.errors import BackendError, UsageError

IDLE: Final = 60.0  # [s] without a chunk, after which a pool is closed; another chunk opens it again
PERIOD: Final = 1.0  # [s] between checks whether a chunk is still wanted
STOP_TIMEOUT: Final = 30.0  # [s] for the clean-up of stopped runs
MOST_KEPT: Final = 64 << 20  # [bytes] of the files of a kept run; larger folders are not sent


class Shipment(NamedTuple):
    """A campaign for Dask workers.

    Args:
        token: Random name of the session.
        version: Version of seoro.
        campaign: Content of `campaign.json`.
        files: Contents of the files of its bundle by path.
    """

    token: str
    version: str
    campaign: str
    files: Mapping[str, bytes]


class Done(NamedTuple):
    """Result of a chunk.

    Args:
        rows: Rows of the runs that have ended, as lines.
        kept: Files of kept runs by number and path.
        died: Reason why the other runs were lost; empty if all have ended.
        was_killed: Whether they were lost because a process was killed from outside.
        error: Reason why the worker cannot make runs; empty if it can.
    """

    rows: Sequence[str] = ()
    kept: Mapping[int, Mapping[str, bytes]] = {}
    died: str = ""
    was_killed: bool = False
    error: str = ""


def ship(shipment: Shipment) -> Shipment:
    """Return a campaign. As a task, it is sent to each worker once, and made again if the workers with it die."""
    return shipment


async def work(shipment: Shipment, key: str, lines: Sequence[str]) -> Done:
    """Make the runs of a chunk.

    Args:
        shipment: The campaign.
        key: Key of this task.
        lines: The runs, as of `Planned.to_line`.
    """
    worker = distributed.get_worker()
    if shipment.version != __version__:
        return Done(error=f"it has seoro {__version__}, the campaign {shipment.version}")
    try:
        host = await _host_of(shipment, worker.id, worker.local_directory, worker.state.nthreads)
        return await host.work([Planned.from_line(line) for line in lines], partial(_is_wanted, worker, key))
    except (BackendError, UsageError, OSError) as error:
        return Done(error=str(error))


async def close(token: str) -> None:
    """Close the pools of a session in this process, and wait for the clean-up of their runs."""
    for at in [each for each in _hosts if each[0] == token]:
        await _close(at)


def _is_wanted(worker: distributed.Worker, key: str) -> bool:
    """Return whether a running task was not cancelled, by its client or because the client is lost."""
    task = worker.state.tasks.get(key)
    return task is not None and task.state != "cancelled"


_hosts: Final[dict[tuple[str, str], asyncio.Task[Host]]] = {}  # by session and worker


async def _host_of(shipment: Shipment, worker: str, folder: str, slots: int) -> Host:
    """Return the pool of a worker, which its first chunk opens.

    Raises:
        BackendError, OSError: It cannot be opened.
    """
    at = shipment.token, worker
    opening = _hosts.get(at)
    if opening is not None and opening.done() and (opening.exception() or opening.result().is_stopped):
        await _close(at)
        opening = None
    if opening is None:
        opening = _hosts[at] = asyncio.create_task(Host.open(shipment, folder, slots))
    return await asyncio.shield(opening)


async def _close(at: tuple[str, str]) -> None:
    opening = _hosts.pop(at, None)
    if opening is not None:
        with suppress(BackendError, OSError):
            await (await opening).close()


class Host:
    """Pool of a Dask worker for one campaign, in a folder of its own. Made by `open`.

    It closes itself if it gets no chunks, for instance because the coordinator has died.

    Attributes:
        is_stopped: Whether its runs were stopped, after which it makes no others.
    """

    def __init__(self, folder: Path, pool: Pool, stack: AsyncExitStack) -> None:
        self._folder = folder
        self._pool = pool
        self._stack = stack
        self._active = self._ended = 0  # chunks
        self.is_stopped = False
        self._idle = asyncio.Event()
        self._idle.set()
        self._expiry = asyncio.create_task(self._expire())

    @classmethod
    async def open(cls, shipment: Shipment, parent: str, slots: int) -> Self:
        """Lay out a campaign, and open its pool.

        Args:
            shipment: The campaign.
            parent: Folder for its folder.
            slots: Number of simultaneous runs.

        Raises:
            OSError: The files cannot be written.
        """
        async with AsyncExitStack() as stack:
            folder = Path(tempfile.mkdtemp(prefix="seoro-", dir=parent))
            stack.callback(shutil.rmtree, folder, ignore_errors=True)
            campaign = await asyncio.to_thread(_lay_out, shipment, folder)
            pool = await stack.enter_async_context(open_pool(campaign, folder, slots))
            return cls(folder, pool, stack.pop_all())

    async def work(self, runs: Sequence[Planned], is_wanted: Callable[[], bool]) -> Done:
        """Make runs, until they are not wanted any more.

        Raises:
            BackendError, UsageError: No worker can be started, or a row cannot be written.
        """
        self._active += 1
        self._idle.clear()
        watching = asyncio.create_task(self._stop_unwanted(is_wanted))
        rows: list[str] = []
        kept: dict[int, Mapping[str, bytes]] = {}
        died, was_killed = "", False
        try:
            async for row in self._pool.run(runs):
                if not row.folder:
                    rows.append(row.to_line())
                    continue
                files = await asyncio.to_thread(_taken, self._folder / row.folder)
                if files is None:
                    rows.append(replace(row, folder="").to_line())
                else:
                    rows.append(row.to_line())
                    kept[row.run] = files
        except WorkerDied as error:
            died, was_killed = str(error), isinstance(error, Killed)
        finally:
            watching.cancel()
            self._active -= 1
            self._ended += 1
            if not self._active:
                self._idle.set()
        return Done(rows, kept, died, was_killed)

    async def _stop_unwanted(self, is_wanted: Callable[[], bool]) -> None:
        while is_wanted():  # noqa: ASYNC110 - Dask has no event for it
            await asyncio.sleep(PERIOD)
        self.is_stopped = True
        self._pool.stop()

    async def _expire(self) -> None:
        ended = -1
        while self._active or self._ended != ended:
            ended = self._ended
            await asyncio.sleep(IDLE)
        self.is_stopped = True
        await self._stack.aclose()

    async def close(self) -> None:
        """Stop the runs in progress, wait for their clean-up, and remove the files."""
        self.is_stopped = True
        self._pool.stop()
        self._expiry.cancel()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._idle.wait(), STOP_TIMEOUT)
        await self._stack.aclose()


def _lay_out(shipment: Shipment, folder: Path) -> CampaignFile:
    """Write the files of a campaign; returns the content of its `campaign.json`, which refers to them."""
    root = folder / "files"
    for name, content in shipment.files.items():
        path = root / check_path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    given = CampaignFile.model_validate_json(shipment.campaign)
    campaign = given.model_copy(update={"manifest": given.manifest.model_copy(update={"root": str(root)})})
    (folder / RUNS).mkdir()
    write_campaign(folder, campaign)
    return campaign


def _taken(folder: Path) -> Mapping[str, bytes] | None:
    """Remove the folder of a kept run; returns its files, or None if they are too large."""
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.is_symlink()]
    try:
        if sum(path.stat().st_size for path in files) > MOST_KEPT:
            return None
        return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
    finally:
        shutil.rmtree(folder, ignore_errors=True)
