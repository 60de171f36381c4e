"""Engine of a Dask cluster."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import Final

import dask.config
import distributed

from seoro.bundle.paths import InvalidPath, check_path
from seoro.campaign.dask.tasks import Done, Shipment, close, ship, work
from seoro.campaign.engine import Killed, MachineLost, WorkerDied
from seoro.campaign.remote.rows import InvalidRow
from seoro.campaign.remote.store import RemoteStore
from seoro.campaign.runs import Planned, Row
from seoro.campaign.store.folder import CampaignFile, CampaignFolder
from seoro.errors import BackendError, UsageError
from seoro.files.inputs import Kind, read_input

LOCAL: Final = "local:"  # begins the address of a cluster that is started here
CONNECT_TIMEOUT: Final = 10.0  # [s]
ANY_PORT: Final = "127.0.0.1:0"
"""Place of the pages that a scheduler serves also without a dashboard; its default port may be in use."""
CLOSE_TIMEOUT: Final = 60.0  # [s] for the clean-up of stopped runs
PERIOD: Final = 2.0  # [s] between counts of the workers
AT_ONCE: Final = 32  # runs of a task, which are made again if its worker dies
MORE: Final = 2  # chunks that wait in the scheduler, so that workers do not wait, and adaptive clusters grow
QUIET: Final = {"distributed.worker.profile.enabled": False, "distributed.admin.tick.interval": "1s"}
"""Settings of Dask workers, whose profiler and checks of themselves take milliseconds per short run."""
MOST_FILES: Final = 256 << 20  # [bytes] of the files of a campaign


@asynccontextmanager
async def open_dask(
    address: str, folder: CampaignFolder, note: Callable[[str], object]
) -> AsyncIterator[DaskEngine]:
    """Use a Dask cluster while the block lasts.

    Args:
        address: Address of its scheduler, or `local:N` for a cluster of N processes on this machine.
        folder: Folder of the campaign.
        note: Called with news about it, for people.

    Raises:
        UsageError: The address is invalid, nothing answers there, or the files are too large.
    """
    shipment = _shipment(folder.campaign)
    async with AsyncExitStack() as stack:
        client = await _connect(address, stack)
        store = RemoteStore(folder, "dask")
        stack.callback(store.close)
        engine = DaskEngine(client, shipment, store, note)
        await engine.count_threads()
        try:
            yield engine
        finally:
            engine.stop()
            with suppress(OSError, TimeoutError, CancelledError):
                closing = client.run(close, shipment.token, on_error="ignore")
                await asyncio.wait_for(closing, CLOSE_TIMEOUT)


class DaskEngine:
    """Engine of a Dask cluster; see `open_dask`."""

    def __init__(
        self,
        client: distributed.Client,
        shipment: Shipment,
        store: RemoteStore,
        note: Callable[[str], object],
    ) -> None:
        self._client = client
        self._token = shipment.token
        self._shipped = client.submit(ship, shipment, key=f"seoro-{shipment.token}")
        self._store = store
        self._note = note
        self._threads = 0
        self._count = 0  # of tasks
        self._futures: set[distributed.Future] = set()
        self._stopping: asyncio.Future[None] | None = None  # its reference

    @property
    def slots(self) -> int:
        """Number of chunks in the scheduler: for each thread of a worker one, and as many that wait."""
        return 2 * self._threads + MORE

    async def slots_changed(self) -> None:
        """Wait until workers have come or gone; see `Engine`."""
        before = self._threads
        while self._threads == before:
            await asyncio.sleep(PERIOD)
            await self.count_threads()

    async def count_threads(self) -> None:
        """Count the threads of all workers.

        Raises:
            BackendError: The scheduler is lost.
        """
        try:
            threads = sum((await self._client.nthreads()).values())
        except OSError as error:
            raise BackendError(f"the connection to the Dask scheduler is lost: {error}") from error
        if not threads and self._threads:
            self._note("the Dask cluster has no workers: waiting for some")
        self._threads = threads

    async def run(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        """Carry out a chunk; see `Engine`. It is divided, since a task is lost as a whole."""
        for start in range(0, len(runs), AT_ONCE):
            part = runs[start : start + AT_ONCE]
            done = await self._done(part)
            for row in self._stored(part, done):
                yield row
            if done.died:
                raise (Killed if done.was_killed else WorkerDied)(done.died)

    def stop(self) -> None:
        """Stop the runs in progress; see `Engine`."""
        self._stopping = asyncio.ensure_future(self._client.cancel(list(self._futures)))

    async def _done(self, runs: Sequence[Planned]) -> Done:
        """Make runs in one task.

        Raises:
            MachineLost: The task was lost, or stopped.
            BackendError: The cluster cannot make runs.
        """
        self._count += 1
        key = f"seoro-run-{self._token}-{self._count}"
        future = self._client.submit(work, self._shipped, key, [each.to_line() for each in runs], key=key)
        self._futures.add(future)
        try:
            done: Done = await future
        except (CancelledError, OSError, distributed.KilledWorker) as error:  # of connections to killed workers
            if self._client.status != "running":
                raise BackendError("the connection to the Dask scheduler is lost") from error
            raise MachineLost(f"Dask workers were lost with the run: {error}") from error
        except Exception as error:  # of a worker, such as a missing package
            raise BackendError(f"a Dask worker cannot make runs: {type(error).__name__}: {error}") from error
        finally:
            self._futures.discard(future)
        if done.error:
            raise BackendError(f"a Dask worker cannot make runs: {done.error}")
        return done

    def _stored(self, runs: Sequence[Planned], done: Done) -> Iterator[Row]:
        """Check the rows of a task; yields them when they are stored."""
        left = {each.number: each for each in runs}
        try:
            for line in done.rows:
                row = self._store.checker.read(line.encode(), left)
                del left[row.run]
                if row.folder:
                    with self._store.kept(row.run) as folder:
                        for name, content in done.kept[row.run].items():
                            path = folder / check_path(name)
                            path.parent.mkdir(parents=True, exist_ok=True)
                            path.write_bytes(content)
                self._store.append(row)
                yield row
        except (InvalidRow, InvalidPath, KeyError) as error:
            raise BackendError(f"a Dask worker sent an invalid result: {error}") from error
        except OSError as error:
            raise UsageError(f"cannot write results: {error.filename}: {error.strerror}") from error


async def _connect(address: str, stack: AsyncExitStack) -> distributed.Client:
    """Connect to a cluster, or start one.

    Raises:
        UsageError: The address is invalid, or nothing answers there.
    """
    place: str | distributed.LocalCluster = address
    if address.startswith(LOCAL):
        number = address.removeprefix(LOCAL)
        if not number.isdecimal() or not int(number):
            raise UsageError(f"invalid Dask cluster `{address}`: expected `local:N` with N processes")
        with dask.config.set(QUIET):
            place = await stack.enter_async_context(
                distributed.LocalCluster(
                    n_workers=int(number),
                    threads_per_worker=1,
                    dashboard_address=None,
                    scheduler_kwargs={"dashboard_address": ANY_PORT},
                    asynchronous=True,
                )
            )
    try:
        return await stack.enter_async_context(
            distributed.Client(place, asynchronous=True, timeout=CONNECT_TIMEOUT, set_as_default=False)
        )
    except (OSError, ValueError) as error:
        raise UsageError(
            f"cannot reach a Dask scheduler at {address}: {error}",
            help="start one with `dask scheduler`, or use `--dask local:N`",
        ) from error


def _shipment(campaign: CampaignFile) -> Shipment:
    """Read the files of a campaign.

    Raises:
        UsageError: They are too large, or cannot be read.
    """
    manifest = campaign.manifest
    if (total := sum(file.size for file in manifest.files)) > MOST_FILES:
        raise UsageError(
            f"the files of the scenario have {total >> 20} MiB; Dask takes at most {MOST_FILES >> 20} MiB",
            help="run the campaign on executors (`--on`)",
        )
    root = Path(manifest.root or ".")
    try:
        files = {file.path: read_input(root / file.path, Kind.BUNDLED) for file in manifest.files}
    except OSError as error:
        raise UsageError(f"cannot read {error.filename}: {error.strerror}") from error
    return Shipment(secrets.token_hex(8), campaign.version, campaign.model_dump_json(), files)
