"""Places where the runs of a campaign are carried out, and their engines."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from seoro.campaign.engine import Engine
from seoro.campaign.pool.pool import open_pool
from seoro.campaign.store.folder import CampaignFolder
from seoro.lang.frozen import Value


class Places(Value):
    """Places of a campaign.

    Args:
        jobs: Number of simultaneous runs on this machine.
    """

    jobs: int = 1


@asynccontextmanager
async def open_engines(folder: CampaignFolder, places: Places) -> AsyncIterator[Engine]:
    """Open the engines of all places while the block lasts.

    Raises:
        UsageError: A place cannot carry out the campaign.
        BackendError: No process can be started.
    """
    async with open_pool(folder.campaign, folder.folder, places.jobs) as pool:
        yield pool
