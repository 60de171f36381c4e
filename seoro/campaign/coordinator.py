"""Coordinator of a campaign: hands planned runs to an engine, in chunks, until none is left."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import anyio

from seoro.campaign.engine import Engine, Killed, MachineLost, NotBegun, WorkerDied
from seoro.campaign.identity import row_of
from seoro.campaign.planner import Planner
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.store.folder import COORDINATOR, CampaignFolder, shard
from seoro.campaign.store.lines import Appender
from seoro.errors import cause_of

CHUNK_TIME: Final = 1.0  # [s] for a chunk of short runs; longer ones are handed out one by one
MOST: Final = 256  # runs of a chunk
ATTEMPTS: Final = 2  # a run that has ended its worker is tried once more, alone
ATTEMPTS_IF_LOST: Final = 5  # the same, for a run whose machine was lost, or whose worker was killed


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
        self._serving = 0  # slots
        self._supplying = anyio.CancelScope()
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
                with self._supplying:
                    while True:
                        while self._serving < self._engine.slots:
                            self._serving += 1
                            group.start_soon(self._serve)
                        await self._engine.slots_changed()
        except ExceptionGroup as errors:
            raise cause_of(errors) from None
        if not self._is_stopping:
            self._planner.check_possible()

    def stop(self) -> None:
        """Begin no more runs, and stop those in progress; they can be resumed."""
        self._is_stopping = True
        self._supplying.cancel()
        self._engine.stop()
        self._wake()

    def _wake(self) -> None:
        self._changed.set()
        self._changed = asyncio.Event()

    async def _serve(self) -> None:
        """Hand out chunks until no run is left, or the slot is gone."""
        while chunk := await self._take():
            self._outstanding += len(chunk)
            try:
                await self._carry_out(chunk)
            finally:
                self._outstanding -= len(chunk)
                self._wake()
        self._serving -= 1
        if chunk is not None:
            self._supplying.cancel()

    async def _take(self) -> list[Planned] | None:
        """Wait for the next chunk; empty if no run is left, None if the slot is gone."""
        while not self._is_stopping:
            if self._serving > self._engine.slots:
                return None
            chunk = self._planner.take(self._chunk)
            if chunk and chunk[0].attempt > 1:  # alone, since it may end its worker again
                for other in chunk[1:]:
                    self._planner.give_back(other)
                return chunk[:1]
            if chunk or not self._outstanding:
                return chunk
            await self._changed.wait()
        return []

    async def _carry_out(self, chunk: list[Planned]) -> None:
        left = {each.number: each for each in chunk}
        duration = 0.0
        try:
            async for row in self._engine.run(chunk):
                del left[row.run]
                duration += row.wall_duration
                self._take_row(row)
        except NotBegun:
            for each in left.values():
                self._planner.give_back(each)
        except WorkerDied as died:
            if not self._is_stopping:
                self._recover(list(left.values()), died)
        ended = len(chunk) - len(left)
        if ended:
            fitting = int(CHUNK_TIME / max(duration / ended, 1e-6))
            self._chunk = max(1, min(MOST, 2 * self._chunk, fitting))

    def _take_row(self, row: Row) -> None:
        self._planner.record(row)
        self._on_row(row)
        if row.status is End.IMPOSSIBLE:
            self._wake()  # another run may take its place
        elif self._is_enough():
            self._is_stopping = True

    def _recover(self, lost: list[Planned], died: WorkerDied) -> None:
        """Return the lost runs to the planner; the first, which had begun, is an error after its last attempt."""
        first, *others = lost
        for each in others:
            self._planner.give_back(each)
        if first.attempt < (ATTEMPTS_IF_LOST if isinstance(died, MachineLost | Killed) else ATTEMPTS):
            self._planner.give_back(replace(first, attempt=first.attempt + 1))
            return
        campaign = self._folder.campaign
        row = row_of(
            first,
            campaign.digest,
            campaign.version,
            status=End.ERROR,
            values=first.values,
            reason=str(died),
            reason_key=str(died),
        )
        file = Appender(shard(self._folder.folder, COORDINATOR))
        try:
            file.append(row.to_line())
        finally:
            file.close()
        self._take_row(row)
