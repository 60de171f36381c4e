"""Coordinator of a campaign: hands planned runs to an engine, in chunks, until none is left."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import anyio

from seoro.campaign.engine import Engine, WorkerDied
from seoro.campaign.identity import row_of
from seoro.campaign.planner import Planner
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.store.folder import COORDINATOR, CampaignFolder, shard
from seoro.campaign.store.lines import Appender
from seoro.errors import cause_of

CHUNK_TIME: Final = 1.0  # [s] for a chunk of short runs; longer ones are handed out one by one
MOST: Final = 256  # runs of a chunk
ATTEMPTS: Final = 2  # a run that has ended its worker is tried once more, alone


class Coordinator:
    """Carries out a campaign.

    Args:
        folder: Its folder.
        planner: Plans its runs.
        engine: Carries them out.
        on_row: Called with the row of each run that ends.
        is_enough: Called after each row; returns whether no more runs shall begin.
    """

    def __init__(
        self,
        folder: CampaignFolder,
        planner: Planner,
        engine: Engine,
        on_row: Callable[[Row], object],
        is_enough: Callable[[], bool] = lambda: False,
    ) -> None:
        self._folder = folder
        self._planner = planner
        self._engine = engine
        self._on_row = on_row
        self._is_enough = is_enough
        self._is_stopping = False
        self._outstanding = 0
        self._changed = asyncio.Event()
        self._chunk = 1  # runs that take about `CHUNK_TIME`

    async def run(self) -> None:
        """Carry out all runs.

        Raises:
            UsageError: No run is possible.
            BackendError: No worker can be started.
        """
        try:
            async with anyio.create_task_group() as group:
                for _ in range(self._engine.slots):
                    group.start_soon(self._serve)
        except ExceptionGroup as errors:
            raise cause_of(errors) from None

    def stop(self) -> None:
        """Begin no more runs, and stop those in progress; they can be resumed."""
        self._is_stopping = True
        self._engine.stop()
        self._wake()

    def _wake(self) -> None:
        self._changed.set()
        self._changed = asyncio.Event()

    async def _serve(self) -> None:
        """Hand out chunks until no run is left."""
        while chunk := await self._take():
            self._outstanding += len(chunk)
            try:
                await self._carry_out(chunk)
            finally:
                self._outstanding -= len(chunk)
                self._wake()

    async def _take(self) -> list[Planned]:
        """Wait for the next chunk; empty if no run is left."""
        while not self._is_stopping:
            chunk = self._planner.take(self._chunk)
            if chunk and chunk[0].attempt > 1:  # alone, since it may end its worker again
                for other in chunk[1:]:
                    self._planner.give_back(other)
                return chunk[:1]
            if chunk or (self._planner.is_over and not self._outstanding):
                return chunk
            if not self._outstanding:
                return []
            await self._changed.wait()
        return []

    async def _carry_out(self, chunk: list[Planned]) -> None:
        left = {each.number: each for each in chunk}
        begun = time.monotonic()
        try:
            async for row in self._engine.run(chunk):
                del left[row.run]
                self._take_row(row)
        except WorkerDied as died:
            if not self._is_stopping:
                self._recover(list(left.values()), str(died))
        ended = len(chunk) - len(left)
        if ended:
            duration = (time.monotonic() - begun) / ended
            self._chunk = max(1, min(MOST, 2 * self._chunk, int(CHUNK_TIME / max(duration, 1e-6))))

    def _take_row(self, row: Row) -> None:
        self._planner.record(row)
        self._on_row(row)
        if row.status is End.IMPOSSIBLE:
            self._wake()  # another run may take its place
        elif self._is_enough():
            self._is_stopping = True

    def _recover(self, lost: list[Planned], reason: str) -> None:
        """Return the lost runs to the planner; the first had begun, and ends as an error if it did so before."""
        first, *others = lost
        for each in others:
            self._planner.give_back(each)
        if first.attempt < ATTEMPTS:
            self._planner.give_back(replace(first, attempt=first.attempt + 1))
            return
        campaign = self._folder.campaign
        row = row_of(
            first,
            campaign.digest,
            campaign.version,
            status=End.ERROR,
            values=first.values,
            reason=reason,
            reason_key=reason,
        )
        file = Appender(shard(self._folder.folder, COORDINATOR))
        try:
            file.append(row.to_line())
        finally:
            file.close()
        self._take_row(row)
