"""Worker of a campaign on an executor, as seen by the coordinator."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from contextlib import aclosing, suppress
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import State
from seoro.bundle.paths import InvalidPath, check_path
from seoro.campaign.engine import MachineLost, WorkerDied
from seoro.campaign.remote.record import row_in
from seoro.campaign.remote.rows import InvalidRow, kept_folder
from seoro.campaign.remote.store import RemoteStore
from seoro.campaign.runs import Planned, Row
from seoro.client.runs import RemoteRun
from seoro.errors import BackendError, BackendLost, BackendRefused, SeoroError, UsageError

MOST_BYTES: Final = 24 << 10  # of runs in one message
END_TIMEOUT: Final = 60.0  # [s] for the clean-up of a stopped worker


class RemoteWorker:
    """Worker on a slot of an executor.

    Args:
        run: Its run at the executor.
        limit: Time without a row after which it hangs [s]; may be infinite.
        changed: Called when it gets ready, or is not usable any more.

    Attributes:
        is_ready: Whether it has loaded the scenario.
        is_busy: Whether it has a chunk.
        done: Set when it is over, or shall end.
    """

    def __init__(self, run: RemoteRun, limit: float, changed: Callable[[], object]) -> None:
        self._run = run
        self._limit = limit
        self._changed = changed
        self._lines: list[bytes] = []
        self._news = asyncio.Event()
        self._over = asyncio.Event()
        self._lost = ""  # reason
        self._part = 0
        self._fetched: list[int] = []
        self.is_ready = self.is_busy = False
        self.done = asyncio.Event()

    @property
    def is_usable(self) -> bool:
        """Whether it takes chunks, now or after its present one."""
        return self.is_ready and not self.done.is_set() and not self._run.info.is_wanted

    # ------------------------------------------------------------ its life

    async def follow(self) -> None:
        """Receive its rows, to its end."""
        try:
            async with aclosing(self._run.lines()) as news:
                async for info, lines in news:
                    self._lines += lines.splitlines(keepends=True)
                    self.is_ready = self.is_ready or (bool(info.announcement) and info.state is State.RUNNING)
                    self._give_way()
                    self._news.set()
                    self._changed()
        except BackendError as error:
            self._lost = str(error)
        finally:
            for event in (self._over, self._news, self.done):
                event.set()
            self._changed()

    def _give_way(self) -> None:
        """End it between chunks, if other runs wait for its slot."""
        if self._run.info.is_wanted and not self.is_busy:
            self.done.set()

    async def close(self) -> None:
        """Stop it, wait for its clean-up, and remove its files at the executor."""
        with suppress(BackendError, TimeoutError):
            async with asyncio.timeout(END_TIMEOUT):
                if not self._over.is_set():
                    await self._run.stop("the campaign has ended")
                    await self._over.wait()
                await self._run.remove()

    async def error(self) -> SeoroError:
        """Return the reason why it has ended before it was ready."""
        if self._lost:
            return BackendLost(self._lost)
        try:
            await self._run.end()
        except SeoroError as error:
            return error
        return BackendError(self._run.info.reason)

    # ------------------------------------------------------------ its runs

    async def make(self, runs: Sequence[Planned], store: RemoteStore) -> AsyncIterator[Row]:
        """Make runs; yields their rows when they are stored.

        Raises:
            WorkerDied: It has ended, and the runs without a row are lost.
            UsageError: A row cannot be stored.
            BackendError: It has sent an invalid row.
        """
        left = {each.number: each for each in runs}
        self.is_busy = True
        try:
            for part in _parts(runs):
                await self._give(part)
            while left:
                rows = []
                for line in await self._next_lines():
                    rows.append(row := store.checker.read(row_in(line), left))
                    del left[row.run]
                await self._fetch([row.run for row in rows if row.folder], store)
                for row in rows:
                    store.append(row)
                    yield row
        except InvalidRow as error:
            raise BackendError(f"the executor '{self._run.executor.name}' sent an {error}") from error
        except (BackendLost, BackendRefused) as error:
            self.done.set()
            raise MachineLost(str(error)) from error
        except OSError as error:
            raise UsageError(f"cannot write results: {error.filename}: {error.strerror}") from error
        finally:
            self.is_busy = False
            self._give_way()
            self._changed()

    async def _give(self, runs: Sequence[Planned]) -> None:
        self._part += 1
        fetched, self._fetched = self._fetched, []
        request = wire.PlannedRuns(
            run=self._run.id,
            part=self._part,
            runs=tuple(_planned(each) for each in runs),
            fetched=tuple(fetched),
        )
        await self._run.executor.ask(wire.GIVE_RUNS, request)

    async def _next_lines(self) -> list[bytes]:
        """Wait for new lines.

        Raises:
            WorkerDied: It has ended, or hangs.
        """
        try:
            async with asyncio.timeout(None if math.isinf(self._limit) else self._limit):
                while not self._lines and not self._over.is_set():
                    self._news.clear()
                    await self._news.wait()
        except TimeoutError:
            self.done.set()
            raise WorkerDied(f"the run did not end within {self._limit:g} s, and was killed") from None
        if not self._lines:
            info = self._run.info
            if info.state is State.ERROR and not self._lost:
                raise WorkerDied(info.reason)
            raise MachineLost(self._lost or f"the worker was {info.state.value}: {info.reason}")
        lines, self._lines = self._lines, []
        return lines

    async def _fetch(self, runs: Sequence[int], store: RemoteStore) -> None:
        """Download the folders of kept runs."""
        if not runs:
            return
        outputs = await self._run.executor.ask(wire.LIST_FILES, wire.OneRun(run=self._run.id))
        for number in runs:
            prefix = f"{kept_folder(number)}/"
            with store.kept(number) as place:
                for name in (file.path for file in outputs.files if file.path.startswith(prefix)):
                    try:
                        path = place / check_path(name.removeprefix(prefix))
                    except InvalidPath as error:
                        raise InvalidRow(f"invalid file name: {error}") from error
                    await self._run.fetch_file(name, path)
        self._fetched += runs


def _planned(run: Planned) -> wire.PlannedRun:
    return wire.PlannedRun(
        number=run.number,
        variant=run.variant,
        repeat=run.repeat,
        seed=run.seed,
        values=dict(run.values),
        strategy=run.strategy,
        parent=run.parent,
        attempt=run.attempt,
    )


def _parts(runs: Sequence[Planned]) -> Iterator[Sequence[Planned]]:
    """Divide a chunk into parts that fit into a message.

    Raises:
        UsageError: The values of a run do not fit.
    """
    part: list[Planned] = []
    size = 0
    for run in runs:
        more = len(run.to_line().encode())
        if more > MOST_BYTES:
            raise UsageError(
                f"the values of run {run.number} have {more} bytes; executors take at most {MOST_BYTES}",
                help="shorten its values, or run the campaign without `--on`",
            )
        if part and (size + more > MOST_BYTES or len(part) == wire.MAX_PLANNED):
            yield part
            part, size = [], 0
        part.append(run)
        size += more
    if part:
        yield part
