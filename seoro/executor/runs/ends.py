"""Ends of runs, which are stored later if the disk is full."""

from __future__ import annotations

import asyncio
import logging
import sqlite3
from collections.abc import Callable
from typing import Final

from seoro.concurrency.condition import Condition
from seoro.executor.storage.store import Finished, Store

KEEP_PAUSE: Final = 5.0  # [s] between attempts to store the end of a run

log = logging.getLogger(__name__)


class Ends:
    """Ends of runs on their way to the storage.

    Args:
        store: Storage of runs.
        changes: Changes of the queue, which an end that cannot be stored is one of.
        on_stored: Called with each run whose end is stored.
    """

    def __init__(self, store: Store, changes: Condition, on_stored: Callable[[str], object]) -> None:
        self._store = store
        self._changes = changes
        self._on_stored = on_stored
        self._unstored: dict[str, Finished] = {}

    async def store(self, run: str, finished: Finished) -> None:
        """Store the end of a run, now or later; without it, the next start would mark the run as lost."""
        if not await self._try_to_store(run, finished):
            log.warning("cannot store the end of the run %s yet", run)
            self._unstored[run] = finished

    async def retry_forever(self) -> None:
        """Store ends that could not be stored at once; runs as long as the executor."""
        while True:
            await self._changes.wait_for(lambda: self._unstored)
            await asyncio.sleep(KEEP_PAUSE)
            await self.retry()

    async def retry(self) -> None:
        """Try once to store them."""
        for run, finished in list(self._unstored.items()):
            if await self._try_to_store(run, finished):
                self.forget(run)

    def forget(self, run: str) -> None:
        """Remove an end that is not stored yet."""
        self._unstored.pop(run, None)

    async def _try_to_store(self, run: str, finished: Finished) -> bool:
        try:
            await self._store.finish(run, finished)
        except sqlite3.Error:  # a full disk
            return False
        self._on_stored(run)
        return True
