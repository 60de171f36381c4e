"""Reader of the rows of a running campaign: those on the disk, then new ones as they end."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from seoro.campaign.numbers import Numbers
from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import read_rows

MOST: Final = 10_000  # rows in memory; a reader that is further behind reads the files again


class RowReader:
    """Yields the row of each run of a campaign once. Runs that constraints exclude are left out.

    Args:
        folder: Folder of the campaign.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._seen = Numbers()
        self._stored: Iterator[Row] = iter(())
        self._is_behind = True  # rows on the disk may be unread
        self._new: deque[Row] = deque()
        self._changed = asyncio.Event()
        self._is_over = False

    def publish(self, row: Row) -> None:
        """Take the row of a run that has ended; it is on the disk."""
        if len(self._new) >= MOST:
            self._new.clear()
            self._is_behind = True
        if not self._is_behind:
            self._new.append(row)
        self._changed.set()

    def finish(self) -> None:
        """End the iteration after the last row."""
        self._is_over = True
        self._changed.set()

    def __aiter__(self) -> RowReader:
        return self

    async def __anext__(self) -> Row:
        await asyncio.sleep(0)  # the campaign goes on while rows are read from the disk
        while True:
            row = self._next()
            if row is None:
                if self._is_over:
                    raise StopAsyncIteration
                self._changed.clear()
                await self._changed.wait()
            elif row.status is not End.IMPOSSIBLE and self._seen.add(row.run):
                return row

    def _next(self) -> Row | None:
        """Return a row that may have been read before; None if all are read."""
        while True:
            row = next(self._stored, None)
            if row is not None:
                return row
            if self._new:
                return self._new.popleft()
            if not self._is_behind:
                return None
            self._is_behind = False
            self._stored = read_rows(self._folder)
