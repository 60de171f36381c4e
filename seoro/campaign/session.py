"""Session of a campaign in the running event loop: begins runs, and yields their rows as they end."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from weakref import WeakSet

import anyio

from seoro.campaign.coordinator import Coordinator
from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.coverage.unreachable import note_unreachable, read_unreachable
from seoro.campaign.opening import open_campaign
from seoro.campaign.places import Places
from seoro.campaign.planner import Planner
from seoro.campaign.reader import RowReader
from seoro.campaign.results.results import Results
from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import Row
from seoro.campaign.space.space import Space
from seoro.campaign.state import State
from seoro.campaign.stopping.grammar import parse_rule
from seoro.campaign.stopping.rate import Rate
from seoro.campaign.stopping.rules import CoverageGoal, Stop
from seoro.campaign.store.folder import CampaignFolder
from seoro.campaign.strategies.choice import make_strategy
from seoro.campaign.strategies.contract import Strategy
from seoro.errors import SeoroError

log = logging.getLogger(__name__)


def _log(note: str) -> None:
    log.warning("%s", note)


def _ignore(_row: Row) -> None:
    pass


class Campaign(Results):
    """Running campaign; see `seoro.campaign.start`. After its block, the results stay readable.

    Args:
        folder: Its open folder, which `running` closes.
        space: Axes of the campaign, and their constraints.
        is_new: Whether to remove the folder if the campaign cannot be started.
        strategy: Its strategy, unless `campaign.json` is enough to make it.

    Attributes:
        space: As given.
        state: Its counts and its pass rate.
        is_discarded: Whether the folder was removed.

    Raises:
        UsageError: A file of the folder is invalid, or the strategy now chooses other values.
    """

    def __init__(
        self, folder: CampaignFolder, space: Space, *, is_new: bool = False, strategy: Strategy | None = None
    ) -> None:
        super().__init__(folder.folder, folder.campaign)
        self.space = space
        if any(isinstance(parse_rule(text), CoverageGoal) for text in folder.campaign.until):
            self._note_unreachable(MergedCoverage(folder.campaign.items))
        self.state = State(folder.campaign, (), read_unreachable(folder.folder))
        self._planner = Planner(
            folder, strategy or make_strategy(folder.campaign.strategy), space, self.state.record_batch
        )
        self.is_discarded = False
        self._opened = folder
        self._is_new = is_new
        self._on_row: Callable[[Row], object] = _ignore
        self._readers: WeakSet[RowReader] = WeakSet()
        self._coordinator: Coordinator | None = None
        self._has_begun: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._is_stopped = self._is_complete = False
        self._is_reported = False  # its error
        self._task: asyncio.Task[None] | None = None

    @property
    def tally(self) -> Tally:
        """Number of runs by how they ended, so far."""
        return self.state.tally

    @property
    def is_over(self) -> bool:
        """Whether no run is active, and none will begin."""
        return self._task is None or self._task.done()

    @property
    def stopped(self) -> Stop | None:
        """Rule or budget that has ended the campaign; None if none has."""
        return self.state.watch.stop

    def rate(self) -> Rate:
        """Return the pass rate with its interval, of the runs before the first that has not ended."""
        return self.state.rate(is_complete=self._is_complete)

    async def runs(self) -> AsyncIterator[Row]:
        """Yield the row of each run once: those of runs that have ended, then others as they end.

        Raises:
            UsageError, BackendError: The campaign cannot continue.
        """
        reader = RowReader(self.folder)
        self._readers.add(reader)
        if self.is_over:
            reader.finish()
        async for row in reader:
            yield row
        await self.wait()

    async def wait(self) -> None:
        """Wait until all runs have ended. Cancelling the wait does not stop the campaign.

        Raises:
            UsageError, BackendError: The campaign cannot continue.
        """
        if self._task is not None:
            await asyncio.wait([self._task])
            if not self._task.cancelled():
                self._is_reported = True
                self._task.result()

    def stop(self) -> None:
        """Begin no more runs, and stop the active ones with their clean-up. `resume` continues the campaign."""
        if self._coordinator is not None and not self.is_over:
            self._is_stopped = True
            self._coordinator.stop()

    # ------------------------------------------------------------ the block

    @asynccontextmanager
    async def running(
        self, places: Places, on_row: Callable[[Row], object] = _ignore, note: Callable[[str], object] = _log
    ) -> AsyncIterator[None]:
        """Carry out the campaign while the block lasts, and close its folder.

        Args:
            places: Places of its runs.
            on_row: Called with the row of each run that ends or that constraints exclude.
            note: Called with news about the places, for people.

        Raises:
            UsageError, BackendError: The campaign cannot be started, or could not continue.
        """
        self._on_row = on_row
        try:
            try:
                await self._begin(places, note)
                yield
            except BaseException as error:
                await self._abort()
                self.is_discarded = self._is_new and not self.tally.runs and isinstance(error, SeoroError)
                raise
            await self._end()
            if self._is_complete:
                self._note_unreachable(self.state.watch.coverage)
        finally:
            if self.is_discarded:
                self._opened.discard()
            else:
                self._opened.close()

    def _note_unreachable(self, coverage: MergedCoverage) -> None:
        """Note which of the buckets without a sample constraints exclude."""
        if self.space.inputs is not None:
            note_unreachable(self.folder, self.space.inputs, coverage)

    async def _begin(self, places: Places, note: Callable[[str], object]) -> None:
        """Begin, and wait until the engine has started."""
        self._task = asyncio.create_task(self._carry_out(places, note))
        await asyncio.wait([self._task, self._has_begun], return_when=asyncio.FIRST_COMPLETED)
        if not self._has_begun.done():
            await self.wait()

    async def _carry_out(self, places: Places, note: Callable[[str], object]) -> None:
        try:
            async with open_campaign(
                self._opened, self._planner, places, self._take, self.state.watch.is_enough, note
            ) as coordinator:
                self._coordinator = coordinator
                self._has_begun.set_result(None)
                if not self.state.watch.is_enough():
                    await coordinator.run()
                self._is_complete = not self._is_stopped
        finally:
            for reader in self._readers:
                reader.finish()

    def _take(self, row: Row) -> None:
        self.state.record(row)
        self._on_row(row)
        for reader in self._readers:
            reader.publish(row)

    async def _end(self) -> None:
        """Stop if it runs; raises its error unless `wait` has raised it."""
        self.stop()
        with anyio.CancelScope(shield=True):
            if not self._is_reported:
                await self.wait()

    async def _abort(self) -> None:
        """Stop at once if it runs, without its error."""
        if self._task is not None:
            self._task.cancel()
            with anyio.CancelScope(shield=True):
                await asyncio.wait([self._task])
            self._is_reported = self._task.cancelled() or self._task.exception() is not None
