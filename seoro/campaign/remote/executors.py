"""Engine of an executor: a worker on each of its slots that the executor grants."""

from __future__ import annotations

import asyncio
import os
import platform
import re
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Final

import anyio

from seoro.bridges.executor.messages import UNAVAILABLE, CampaignWorker, ExecutorInfo
from seoro.bridges.wire import LabResult
from seoro.bundle.pack import Bundle
from seoro.bundle.unpack import limit_of
from seoro.campaign.engine import NotBegun
from seoro.campaign.pool.pool import MARGIN
from seoro.campaign.pool.simulators import own_simulator
from seoro.campaign.remote.store import RemoteStore
from seoro.campaign.remote.worker import RemoteWorker
from seoro.campaign.runs import Planned, Row
from seoro.campaign.store.folder import CampaignFile, CampaignFolder
from seoro.client import Client
from seoro.concurrency.background import background
from seoro.errors import BackendError, BackendLost, BackendRefused, InvalidScenario, SeoroError, UsageError

PATIENCE: Final = 15.0  # [s] for which an executor may be unreachable, before others get its runs
STOP_IF_LOST: Final = 30.0  # [s] after which an executor stops workers whose coordinator is lost
RETRY: Final = 3.0  # [s] between attempts to reach a lost executor


@asynccontextmanager
async def open_executor(
    client: Client, name: str, folder: CampaignFolder, note: Callable[[str], object]
) -> AsyncIterator[ExecutorEngine]:
    """Use an executor while the block lasts.

    Args:
        client: Reaches it.
        name: Its name.
        folder: Folder of the campaign.
        note: Called with news about its state, for people.

    Raises:
        UsageError: The executor is unknown, too old, or misses something.
        BackendError: It does not answer.
    """
    engine = ExecutorEngine(client, name, folder, note)
    try:
        jobs = (await engine.check()).jobs
        async with background() as slots:
            for number in range(1, jobs + 1):
                slots.start_soon(engine.hold_slot, number)
            yield engine
    finally:
        engine.close()


class ExecutorEngine:
    """Engine of an executor; see `open_executor`."""

    def __init__(self, client: Client, name: str, folder: CampaignFolder, note: Callable[[str], object]) -> None:
        self._client = client
        self._name = name
        self._campaign = folder.campaign
        self._note = note
        self._noted = ""  # last problem
        self._bundle = _bundle_of(folder.campaign)
        self._plain_name = re.sub(r"[^\w.-]", "_", name)  # for files
        self._store = RemoteStore(folder, f"on-{self._plain_name}")
        self._limit = limit_of(folder.campaign.manifest.options).seconds + MARGIN
        self._workers: list[RemoteWorker] = []
        self._count = 0  # of workers
        self._changed = asyncio.Event()
        self._error: SeoroError | None = None
        self._has_begun = self._is_stopping = False
        self._accepted = asyncio.Event()  # first worker, whose submission has sent the files

    # ------------------------------------------------------------ as an engine

    @property
    def slots(self) -> int:
        """Number of ready workers."""
        return sum(worker.is_usable for worker in self._workers)

    async def slots_changed(self) -> None:
        """Wait for a change of any worker; see `Engine`."""
        await self._changed.wait()
        self._changed.clear()
        if self._error is not None:
            raise self._error

    async def run(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        """Carry out a chunk; see `Engine`. Unless runs share a worker, only its first run."""
        worker = next((each for each in self._workers if each.is_usable and not each.is_busy), None)
        if worker is None:
            raise NotBegun(f"the executor '{self._name}' has no free worker")
        is_shared = self._campaign.isolation == "worker"
        async for row in worker.make(runs if is_shared else runs[:1], self._store):
            yield row
        if not is_shared:
            worker.done.set()
            self._changed.set()
            raise NotBegun("each run has a worker of its own")

    def stop(self) -> None:
        """Stop the runs in progress; see `Engine`."""
        self._is_stopping = True
        for worker in self._workers:
            worker.done.set()

    def close(self) -> None:
        """Close its shard."""
        self._store.close()

    # ------------------------------------------------------------ workers

    async def check(self) -> ExecutorInfo:
        """Check that the executor can carry out the campaign; returns its description.

        Raises:
            UsageError: It cannot.
            BackendError: It does not answer.
        """
        [found] = await self._client.describe(self._name)
        wanted, simulator = self._campaign.version, own_simulator(self._campaign.manifest.options.simulator)
        if found.info.version != wanted:
            raise UsageError(
                f"the executor '{self._name}' has seoro {found.info.version}, the campaign {wanted}: its runs "
                "need one version",
                help=f"install seoro {wanted} there",
            )
        known = found.info.simulators
        if simulator is not None and known is not None and simulator not in known:
            installed = ", ".join(known) or "none"
            raise UsageError(
                f"the executor '{self._name}' has no simulator '{simulator}' (installed: {installed})",
                help=f"install it there: pip install 'seoro[{simulator}]'",
            )
        return found.info

    async def hold_slot(self, number: int) -> None:
        """Keep a worker on a slot, and replace it when it ends.

        Args:
            number: Number of the slot, for its name.
        """
        if number > 1:
            await self._accepted.wait()
        while not self._is_stopping:
            try:
                if self._noted:  # it may have been started again, as another version
                    await self.check()
                await self._hold_worker(f"{self._plain_name}-{platform.node()}-{os.getpid():x}-{number}")
            except (InvalidScenario, UsageError, BackendError) as error:
                if not self._accepted.is_set() and _is_final(error):
                    self._fail(error, "accepts no runs of the campaign")
                    return
                self._note_problem(f"{error}; others get its runs")
                await anyio.sleep(RETRY)

    async def _hold_worker(self, name: str) -> None:
        """Keep a worker until it ends, is lost, or gives way.

        Raises:
            UsageError, BackendError: It cannot be started now.
        """
        self._count += 1
        campaign = CampaignWorker(
            name=f"{name}-{self._count}",
            digest=self._campaign.digest,
            version=self._campaign.version,
            keep=self._campaign.keep,
            parquet=self._campaign.parquet,
            has_own_python=self._campaign.isolation == "process",
        )
        with anyio.CancelScope(shield=True):  # or a submitted worker would be left
            run = await self._client.submit_bundle(self._name, self._bundle, STOP_IF_LOST, campaign=campaign)
        self._accepted.set()
        worker = RemoteWorker(run, self._limit, self._note_change)
        following = asyncio.create_task(worker.follow())  # also while this task is cancelled
        self._workers.append(worker)
        try:
            await worker.done.wait()
            if not worker.is_ready and not self._is_stopping:
                self._refuse(await worker.error())
        finally:
            self._workers.remove(worker)
            self._changed.set()
            with anyio.CancelScope(shield=True):
                await worker.close()
                following.cancel()

    def _refuse(self, error: SeoroError) -> None:
        """Handle the end of a worker that has not loaded the scenario.

        Raises:
            UsageError, BackendError: The executor can be tried again.
        """
        if self._has_begun or isinstance(error, BackendLost):
            raise error
        self._fail(error, "cannot run the scenario")

    def _fail(self, error: SeoroError, effect: str) -> None:
        """End the campaign by an error of its beginning."""
        self._note(f"the executor '{self._name}' {effect}")
        self._error = error
        self._is_stopping = True
        self._changed.set()

    def _note_change(self) -> None:
        if self._noted and self.slots:
            self._note(f"the executor '{self._name}' works again")
            self._noted = ""
        self._has_begun = self._has_begun or self.slots > 0
        self._changed.set()

    def _note_problem(self, problem: str) -> None:
        if problem != self._noted:
            self._noted = problem
            self._note(problem)


def _is_final(error: SeoroError) -> bool:
    """Whether a refused submission would be refused again: by a role, a limit or a full disk."""
    return isinstance(error, BackendRefused) and error.code not in (LabResult.STOPPED, UNAVAILABLE)


def _bundle_of(campaign: CampaignFile) -> Bundle:
    root = Path(campaign.manifest.root or ".")
    return Bundle(campaign.manifest, {file.hash: root / file.path for file in campaign.manifest.files})
