"""Reading the trace of a run while it goes on.

`Readers` is an observer. It keeps the last records, or all of them, and hands them to any number of readers, each
at its own pace. No reader ever misses a record: one that comes when the first records are gone is refused, and on
clocks of which the runtime is the master, time stands still while a reader is behind by more than what is kept. On
the real clock time passes anyway, and the records that a slow reader has not read yet are kept for it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Coroutine
from typing import Any
from weakref import WeakSet

import anyio

from seoro.changes import Changes
from seoro.errors import InvalidUse
from seoro.runtime.contracts import Clock

WINDOW = 1000  # records that are kept of a trace that is not kept whole
LOOK_AGAIN = 0.05  # [s]; a reader that is dropped tells nobody


class Readers:
    """Keeps the records of a run for those who read them.

    Args:
        keep_all: Whether to keep the whole trace, and so never to wait for a reader.
    """

    def __init__(self, keep_all: bool) -> None:
        self._keep_all = keep_all
        self._records: deque[dict[str, Any]] = deque()
        self._first = 0  # number of the first record that is kept
        self._readers: WeakSet[TraceReader] = WeakSet()  # one that its program has dropped holds nothing up
        self._waits_for_none = keep_all
        self._over = False
        self._more = Changes()
        self._moved = Changes()

    def record(self, record: dict[str, Any]) -> None:
        """Take a record."""
        self._records.append(record)
        if not self._keep_all and len(self._records) > WINDOW:
            self._forget()
        self._more.tell()

    def _forget(self) -> None:
        """Drop what is beyond the window, but nothing that a reader has not read."""
        read = self._end
        if self._readers:
            read = min((reader.position for reader in self._readers), default=read)
        while len(self._records) > WINDOW and self._first < read:
            self._records.popleft()
            self._first += 1

    def end(self) -> None:
        """The run is over: there will be no more records."""
        self._over = True
        self._more.tell()

    # -------------------------------------------------------- reading

    def open(self) -> TraceReader:
        """A reader, from the first record on.

        Raises:
            InvalidUse: The first record is not there any more.
        """
        if self._first > 0:
            raise InvalidUse(
                f"the first {self._first} records of the trace are gone: only the last {WINDOW} are kept",
                help="read the trace from the start of the run, or start the run with `keep_trace=True`",
            )
        reader = TraceReader(self)
        self._readers.add(reader)
        return reader

    async def at(self, position: int) -> dict[str, Any] | None:
        """The record of a number, once there is one; None if there will not be."""
        while position >= self._end:
            if self._over:
                return None
            await self._more.wait()
        return self._records[position - self._first]

    def moved(self) -> None:
        """A reader has read on."""
        self._moved.tell()

    def leave(self, reader: TraceReader) -> None:
        """A reader reads no more."""
        self._readers.discard(reader)
        self.moved()

    @property
    def _end(self) -> int:
        return self._first + len(self._records)

    # -------------------------------------------------------- waiting for slow readers

    @property
    def are_behind(self) -> bool:
        """Whether a reader is so far behind that time has to wait for it."""
        if self._waits_for_none or len(self._records) < WINDOW or not self._readers:
            return False
        return any(self._end - reader.position >= WINDOW for reader in self._readers)

    async def wait_until_read(self, interrupt: anyio.Event) -> None:
        """Wait until none is too far behind, or until something happens that the run has to react to."""
        async with anyio.create_task_group() as group:
            group.start_soon(_call_when_set, interrupt, group.cancel_scope)
            while self.are_behind:
                with anyio.move_on_after(LOOK_AGAIN):
                    await self._moved.wait()
            group.cancel_scope.cancel()

    def wait_no_more(self) -> None:
        """The run is to end: from now on no reader holds it up."""
        self._waits_for_none = True
        self.moved()


async def _call_when_set(event: anyio.Event, scope: anyio.CancelScope) -> None:
    await event.wait()
    scope.cancel()


class TraceReader:
    """Reads a trace, from the first record to `run.end`, as they come: `async for record in reader`.

    A reader that is not read holds up a run of which the trace is not kept whole. Close it, or drop it, as a loop
    does that is left. Records are shared with all other readers; they are not to be changed.
    """

    def __init__(self, readers: Readers) -> None:
        self._readers = readers
        self.position = 0  # number of the record that is read next

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
        """Read no more."""
        self._readers.leave(self)


class ReadClock:
    """A clock that the runtime is the master of, and that stands still while a reader is far behind.

    Args:
        clock: The run's clock.
        readers: Of its trace.
    """

    deterministic = True

    def __init__(self, clock: Clock, readers: Readers) -> None:
        self._clock = clock
        self._readers = readers
        self.name = clock.name
        self.start = clock.start
        self.now = clock.now

    def skip(self, due: float) -> bool:
        """Be there at once, if the clock can and all readers are near."""
        return not self._readers.are_behind and self._clock.skip(due)

    def pass_time(self, due: float | None, interrupt: anyio.Event) -> Coroutine[Any, Any, None]:
        """Let time pass, once all readers are near."""
        if self._readers.are_behind:
            return self._wait_and_pass(due, interrupt)
        return self._clock.pass_time(due, interrupt)

    async def _wait_and_pass(self, due: float | None, interrupt: anyio.Event) -> None:
        await self._readers.wait_until_read(interrupt)
        if not interrupt.is_set():
            await self._clock.pass_time(due, interrupt)
