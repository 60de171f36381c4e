"""Places where the runs of a campaign are carried out, and their engines."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from importlib.util import find_spec
from typing import Final

from seoro.campaign.engine import Engine
from seoro.campaign.engines import Engines
from seoro.campaign.jobs import shared_place, simultaneous_runs
from seoro.campaign.pool.pool import open_pool
from seoro.campaign.store.folder import CampaignFolder
from seoro.embed.options import Options
from seoro.errors import UsageError
from seoro.lang.frozen import Value

HERE: Final = "local"  # name of this machine among executors


class Places(Value):
    """Places of a campaign.

    Args:
        jobs: Number of simultaneous runs on this machine; None for one per processor.
        on: Names of executors, and `local` for this machine. Without them and `dask`, it is this machine.
        executor: Endpoint of the executors; None for the default of `seoro.Client`.
        dask: Address of a Dask scheduler, or `local:N`; None without one.
        most: Maximum number of simultaneous chunks; None for all slots.
    """

    jobs: int | None = None
    on: tuple[str, ...] = ()
    executor: str | None = None
    dask: str | None = None
    most: int | None = None

    @property
    def executors(self) -> tuple[str, ...]:
        """Names of the executors, each once."""
        return tuple(dict.fromkeys(name for name in self.on if name != HERE))

    @property
    def is_here(self) -> bool:
        """Whether runs are carried out on this machine."""
        return HERE in self.on or (not self.on and self.dask is None)


def checked_places(places: Places, options: Options) -> Places:
    """Check places, and set the number of simultaneous runs.

    Args:
        places: Places that a user has chosen.
        options: Options that all runs share.

    Raises:
        UsageError: They contradict each other, or the runs cannot be simultaneous.
    """
    if places.executor is not None and not places.executors:
        raise UsageError("an endpoint of executors is given, but no executor", help="add `--on NAME`")
    if places.jobs is not None and not places.is_here:
        raise UsageError("`--jobs` is for runs on this machine", help=f"add `--on {HERE}`, or leave it out")
    if places.dask is not None and find_spec("distributed") is None:
        raise UsageError("`--dask` needs Dask", help="pip install 'seoro[dask]'")
    jobs = simultaneous_runs(options, places.jobs) if places.is_here else 0
    return replace(places, jobs=jobs, most=None if shared_place(options) is None else 1)


@asynccontextmanager
async def open_engines(
    folder: CampaignFolder, places: Places, note: Callable[[str], object]
) -> AsyncIterator[Engine]:
    """Open the engines of all places while the block lasts.

    Args:
        folder: Folder of the campaign.
        places: Checked places.
        note: Called with news about them, for people.

    Raises:
        UsageError: A place cannot carry out the campaign.
        BackendError: A place does not answer, or no process can be started.
    """
    engines: list[Engine] = []
    async with AsyncExitStack() as stack:
        if places.jobs:
            engines.append(await stack.enter_async_context(open_pool(folder.campaign, folder.folder, places.jobs)))
        if places.executors:
            # Zenoh, for campaigns on executors only.
            from seoro.campaign.remote.executors import PATIENCE, open_executor  # noqa: PLC0415
            from seoro.client import Client  # noqa: PLC0415

            client = await stack.enter_async_context(Client(places.executor, patience=PATIENCE))
            for name in places.executors:
                engines.append(await stack.enter_async_context(open_executor(client, name, folder, note)))
        if places.dask is not None:
            from seoro.campaign.dask.engine import open_dask  # noqa: PLC0415 - an extra

            engines.append(await stack.enter_async_context(open_dask(places.dask, folder, note)))
        yield Engines(engines, places.most)
