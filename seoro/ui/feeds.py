"""Reading of traces, once for all viewers of a run."""

from __future__ import annotations

import time
from collections.abc import AsyncGenerator, AsyncIterator, Iterator
from contextlib import aclosing, asynccontextmanager, closing
from pathlib import Path
from tempfile import SpooledTemporaryFile, TemporaryDirectory, TemporaryFile
from typing import IO, Final

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from seoro.client.runs import RemoteRun
from seoro.errors import BackendError
from seoro.report.following import OpenTrace, TraceFile
from seoro.report.live import Cursor, LiveRun
from seoro.ui.answers import RequestError, as_request_error
from seoro.ui.registry import LocalSource, RunRegistry
from seoro.ui.results import fetch_of_pages

_GROWING: Final = 0.008  # [s] between looks at a trace that grows: half a frame of a display
_QUIET: Final = 0.05  # [s] the same for one that has not grown for some time
_SLOWER: Final = 1.1  # factor of this time after each look that finds nothing
_ENDED: Final = 1.0  # [s] the same for a finished one, which another run may replace
PIECE: Final = 1 << 20  # [bytes] of a frame in memory, and of a message
_KEPT: Final = 60.0  # [s] without viewers
_MOST_KEPT: Final = 8  # feeds without viewers


class Feed:
    """Reads the trace of a run for its viewers.

    Args:
        run: Id of the run.
        registry: Known runs.

    Attributes:
        problem: Reason why the trace cannot be read on; empty if it can.
        viewers: Number of viewers.
        left: Time at which the last viewer left, by the monotonic clock [s].
        scope: Scope of `read`.
    """

    def __init__(self, run: str, registry: RunRegistry) -> None:
        self.problem = ""
        self.viewers = 0
        self.left = time.monotonic()
        self.scope = anyio.CancelScope()
        self._id = run
        self._registry = registry
        self._run = LiveRun()
        self._has_data = False
        self._changed = anyio.Event()

    async def read(self) -> None:
        """Read the trace to its end; in a folder also those of the runs that replace it."""
        with self.scope:
            try:
                source = self._registry.get(self._id).source
                if isinstance(source, LocalSource):
                    await self._read_file(source)
                else:
                    await self._read_remote(RemoteRun(source.executor, source.info))
            except (OSError, BackendError, RequestError) as error:  # unreadable, or deleted
                self.problem = str(error)
                self._notify()

    async def _read_file(self, source: LocalSource) -> None:
        with closing(TraceFile(source.trace, self._run, source.folder)) as file:
            pause = _GROWING
            while True:
                is_ended = self._registry.get(self._id).run.status.is_final  # before the last read
                pause = min(_SLOWER * pause, _QUIET)
                while await anyio.to_thread.run_sync(file.poll):
                    self._notify()
                    pause = _GROWING
                if is_ended and not self._run.is_finished:
                    await anyio.to_thread.run_sync(file.finish)
                    self._notify()
                await anyio.sleep(_ENDED if is_ended else pause)

    async def _read_remote(self, run: RemoteRun) -> None:
        with TemporaryFile() as file, closing(OpenTrace(file)) as trace:
            self._run.restart(trace.read_at)
            async with aclosing(run.lines()) as parts:
                async for _, lines in parts:
                    if lines:
                        await anyio.to_thread.run_sync(_append, file, lines)
                        await anyio.to_thread.run_sync(self._run.feed, lines)
                        self._notify()
            with TemporaryDirectory(prefix="seoro-") as folder:
                await fetch_of_pages(run, Path(folder))
                await anyio.to_thread.run_sync(self._run.finish, Path(folder))
            self._notify()
            await anyio.sleep_forever()  # viewers read blocks of records

    def _notify(self) -> None:
        self._has_data = True
        self._changed.set()
        self._changed = anyio.Event()

    async def frames(self) -> AsyncGenerator[bytes, None]:
        """Yield all data, then new data since the frame before, until an error of the trace.

        Yields:
            Pieces of the frames. The first byte of a piece is 1 if more pieces of the same frame follow.

        Raises:
            RequestError: The disk is full.
        """
        cursor: Cursor | None = None
        while not self.problem:
            changed = self._changed
            if self._has_data and not self._run.is_current(cursor):
                with SpooledTemporaryFile(PIECE) as file:
                    try:
                        cursor = await anyio.to_thread.run_sync(_write_frame, self._run, file, cursor)
                    except OSError as error:
                        raise as_request_error(error) from error
                    for piece in _pieces(file):
                        yield piece
            else:
                await changed.wait()

    async def block(self, number: int) -> bytes:
        """Return the compressed lines of a block, once it is read.

        Raises:
            RequestError: The block does not exist.
        """
        while True:
            changed, is_read = self._changed, self._run.is_finished or bool(self.problem)
            try:
                return await anyio.to_thread.run_sync(self._run.block, number)
            except IndexError:
                if is_read:
                    raise RequestError(404, "unknown block of records") from None
            except OSError as error:
                raise as_request_error(error) from error
            await changed.wait()


def _write_frame(run: LiveRun, file: IO[bytes], cursor: Cursor | None) -> Cursor:
    cursor = run.write_frame(file.write, cursor)
    file.seek(0)
    return cursor


def _pieces(file: IO[bytes]) -> Iterator[bytes]:
    """Yield the pieces of a frame, which may have several megabytes."""
    piece = file.read(PIECE)
    while following := file.read(PIECE):
        yield b"\1" + piece
        piece = following
    yield b"\0" + piece


def _append(file: IO[bytes], lines: bytes) -> None:
    file.write(lines)
    file.flush()


class Feeds:
    """Feeds of all viewed runs.

    Args:
        registry: Known runs.
        tasks: Task group for the feeds.
    """

    def __init__(self, registry: RunRegistry, tasks: TaskGroup) -> None:
        self._registry = registry
        self._tasks = tasks
        self._feeds: dict[str, Feed] = {}

    @asynccontextmanager
    async def viewing(self, run: str) -> AsyncIterator[Feed]:
        """View a run while the block lasts.

        Raises:
            RequestError: The run is unknown.
        """
        self._registry.get(run)
        feed = self._feeds.get(run)
        if feed is None:
            feed = self._feeds[run] = Feed(run, self._registry)
            self._tasks.start_soon(feed.read)
        feed.viewers += 1
        try:
            yield feed
        finally:
            feed.viewers -= 1
            feed.left = time.monotonic()
            if feed.problem and not feed.viewers:
                self._forget(run)  # the next viewer tries again

    async def forget_unused(self) -> None:
        """End feeds some time after their last viewer, in an endless loop."""
        while True:
            unused = sorted((feed.left, run) for run, feed in self._feeds.items() if not feed.viewers)
            now = time.monotonic()
            for index, (left, run) in enumerate(reversed(unused)):
                if index >= _MOST_KEPT or now - left > _KEPT:
                    self._forget(run)
            await anyio.sleep(1.0)

    def _forget(self, run: str) -> None:
        feed = self._feeds.pop(run, None)
        if feed is not None:
            feed.scope.cancel()
