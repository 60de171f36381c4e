"""Readers of the trace of a running scenario.

`Readers` is an observer. It keeps the last records, or all of them, for any number of readers, each at its own
pace. No reader misses a record. A reader that starts after the first records were dropped is refused. On
deterministic clocks, time stands still while a reader is more than the window behind. On the real clock, records
that a slow reader has not read are kept for it.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Coroutine
from typing import Any, Protocol
from weakref import WeakSet

from seoro.concurrency.condition import Condition
from seoro.errors import UsageError
from seoro.runtime.kernel.clock import NEXT, TIME_DIGITS, Clock

WINDOW = 1000  # records kept, unless the whole trace is kept
LOOK_AGAIN = 0.05  # [s]; dropped readers do not notify


class Follower(Protocol):
    """Receives the events of a trace as they are recorded."""

    @property
    def is_full(self) -> bool:
        """Whether time has to wait for it."""

    def record(self, record: dict[str, Any]) -> None:
        """Handle an `event` record."""

    def end(self) -> None:
        """Handle the end of the run."""


class Readers:
    """Keeps the records of a run for readers.

    Args:
        keep_all: Whether to keep the whole trace, which avoids waiting for readers.
    """

    def __init__(self, keep_all: bool) -> None:
        self._keep_all = keep_all
        self._records: deque[dict[str, Any]] = deque()
        self._first = 0  # number of the first kept record
        self._readers: WeakSet[TraceReader] = WeakSet()  # weak: dropped readers hold up nothing
        self._followers: tuple[Follower, ...] = ()
        self._waits_for_none = False
        self._over = False
        self._more = Condition()
        self._moved = Condition()

    def record(self, record: dict[str, Any]) -> None:
        """Add a record."""
        self._records.append(record)
        if not self._keep_all and len(self._records) > WINDOW:
            self._forget()
        if self._followers and record["kind"] == "event":
            for follower in self._followers:
                follower.record(record)
        self._more.notify_all()

    def _forget(self) -> None:
        """Drop records beyond the window that all readers have read."""
        read = self._end
        if self._readers:
            read = min((reader.position for reader in self._readers), default=read)
        while len(self._records) > WINDOW and self._first < read:
            self._records.popleft()
            self._first += 1

    def end(self) -> None:
        """Note the end of the run."""
        self._over = True
        self._more.notify_all()
        for follower in self._followers:
            follower.end()

    # -------------------------------------------------------- following events

    def follow(self, follower: Follower) -> None:
        """Send the events from now on to a follower."""
        self._followers = (*self._followers, follower)
        if self._over:
            follower.end()

    def unfollow(self, follower: Follower) -> None:
        """Stop sending events to a follower."""
        self._followers = tuple(each for each in self._followers if each is not follower)
        self.moved()

    # -------------------------------------------------------- reading

    def open(self) -> TraceReader:
        """Return a reader that starts at the first record.

        Raises:
            UsageError: The first record has been dropped.
        """
        if self._first > 0:
            raise UsageError(
                f"the first {self._first} records of the trace were dropped: only the last {WINDOW} are kept",
                help="read the trace from the start of the run, or start the run with `keep_trace=True`",
            )
        reader = TraceReader(self)
        self._readers.add(reader)
        return reader

    async def at(self, position: int) -> dict[str, Any] | None:
        """Wait for the record of a number and return it; None after the end."""
        while position >= self._end:
            if self._over:
                return None
            await self._more.wait()
        return self._records[position - self._first]

    def moved(self) -> None:
        """Note that a reader has progressed."""
        self._moved.notify_all()

    def leave(self, reader: TraceReader) -> None:
        """Remove a reader."""
        self._readers.discard(reader)
        self.moved()

    @property
    def _end(self) -> int:
        return self._first + len(self._records)

    # -------------------------------------------------------- waiting for slow readers

    @property
    def are_behind(self) -> bool:
        """Whether a reader or a follower is so far behind that time has to wait."""
        if self._waits_for_none:
            return False
        if self._followers and any(follower.is_full for follower in self._followers):
            return True
        if self._keep_all or len(self._records) < WINDOW or not self._readers:
            return False
        return any(self._end - reader.position >= WINDOW for reader in self._readers)

    async def wait_until_read(self, interrupt: asyncio.Event) -> None:
        """Wait until no reader is too far behind, or until an interrupt."""
        import anyio  # noqa: PLC0415 - for slow readers only

        async def cancel_when_set() -> None:
            await interrupt.wait()
            group.cancel_scope.cancel()

        async with anyio.create_task_group() as group:
            group.start_soon(cancel_when_set)
            while self.are_behind:
                with anyio.move_on_after(LOOK_AGAIN):
                    await self._moved.wait()
            group.cancel_scope.cancel()

    def wait_no_more(self) -> None:
        """Stop waiting for readers: the run is ending."""
        self._waits_for_none = True
        self.moved()


class TraceReader:
    """Iterates over a trace from the first record to `run.end`: `async for record in reader`.

    An idle reader holds up a run whose trace is not kept whole. Close it or drop it, as leaving the loop does.
    Records are shared with other readers and must not be changed.
    """

    def __init__(self, readers: Readers) -> None:
        self._readers = readers
        self.position = 0  # number of the next record

    def __aiter__(self) -> TraceReader:
        return self

    async def __anext__(self) -> dict[str, Any]:
        record = await self._readers.at(self.position)
        if record is None:
            raise StopAsyncIteration
        self.position += 1
        self._readers.moved()
        return record

    async def aclose(self) -> None:
        """Stop reading."""
        self._readers.leave(self)


class ReadClock:
    """Deterministic clock that stands still while a reader is far behind.

    The next instant is exempt: it contains emissions of the application, which a reader may be waiting for.

    Args:
        clock: The run's clock.
        readers: Readers of its trace.
    """

    deterministic = True

    def __init__(self, clock: Clock, readers: Readers) -> None:
        self._clock = clock
        self._readers = readers
        self.name = clock.name
        self.start = clock.start
        self.now = clock.now

    def skip(self, due: float) -> bool:
        """Advance immediately, if the clock can and no reader is far behind."""
        return (self._is_next(due) or not self._readers.are_behind) and self._clock.skip(due)

    def pass_time(self, due: float | None, interrupt: asyncio.Event) -> Coroutine[Any, Any, None]:
        """Let time pass, once no reader is far behind."""
        if self._readers.are_behind and not self._is_next(due):
            return self._wait_and_pass(due, interrupt)
        return self._clock.pass_time(due, interrupt)

    def _is_next(self, due: float | None) -> bool:
        """Whether no instant is possible before a time."""
        return due is not None and round(due - self.now(), TIME_DIGITS) <= NEXT

    async def _wait_and_pass(self, due: float | None, interrupt: asyncio.Event) -> None:
        await self._readers.wait_until_read(interrupt)
        if not interrupt.is_set():
            await self._clock.pass_time(due, interrupt)
