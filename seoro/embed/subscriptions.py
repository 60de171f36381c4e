"""Subscriptions of applications: occurrences of an event of a run in a bounded buffer."""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any, Final, Literal, TypeAlias, get_args

from seoro.concurrency.condition import Condition
from seoro.embed.arguments import to_whole
from seoro.errors import SubscriptionOverflow, UsageError
from seoro.runtime.events.occurrence import Occurrence, occurrence_in, without_attempts
from seoro.runtime.trace.reader import Readers

CAPACITY: Final = 1000  # occurrences, by default

OnFull: TypeAlias = Literal["drop_oldest", "fail", "wait"]


def check_buffer(capacity: int, on_full: str, no_wait_reason: str) -> None:
    """Check the buffer options of a subscription.

    Args:
        capacity: Capacity of the buffer.
        on_full: Policy for a full buffer.
        no_wait_reason: Reason why `wait` is impossible; empty if it is possible.

    Raises:
        UsageError: An option is invalid, or impossible for this run.
    """
    if to_whole("capacity", capacity) < 1:
        raise UsageError(f"invalid capacity {capacity}: expected at least 1")
    if on_full not in get_args(OnFull):
        known = ", ".join(f'"{each}"' for each in get_args(OnFull))
        raise UsageError(f"invalid `on_full`: expected one of {known}, found {on_full!r}")
    if on_full == "wait" and no_wait_reason:
        others = 'use `on_full="fail"` or `on_full="drop_oldest"`'
        raise UsageError(f'`on_full="wait"` is impossible: {no_wait_reason}', help=others)


class EventSubscription:
    """Occurrences of one event, in order: `async for occurrence in events`. Opened by `subscribe`.

    The iteration ends with the run. With `on_full="wait"`, an occurrence occupies the buffer until the program
    asks for the next one.

    Args:
        event: Name of the event.
        capacity: Capacity of the buffer.
        on_full: Policy for a full buffer.
        moved: Called when the buffer has space again.
    """

    def __init__(
        self, event: str, capacity: int, on_full: OnFull, moved: Callable[[], object] = lambda: None
    ) -> None:
        self._event = event
        self._capacity = capacity
        self._on_full = on_full
        self._moved = moved
        self._buffer: deque[Occurrence] = deque()
        self._processing = 0  # 1 while the program processes an occurrence
        self._failure: Exception | None = None
        self._is_over = False
        self._more = Condition()
        self.lost = 0  # occurrences that were dropped

    def __aiter__(self) -> EventSubscription:
        return self

    async def __anext__(self) -> Occurrence:
        """Wait for the next occurrence, and return it.

        Raises:
            SubscriptionOverflow: The buffer was full, and later occurrences were lost.
        """
        if self._processing:
            self._processing = 0
            self._moved()
        while not self._buffer:
            self._check_end()
            await self._more.wait()
        self._processing = 1
        return self._buffer.popleft()

    def _check_end(self) -> None:
        if self._on_full == "fail" and self.lost:
            raise SubscriptionOverflow(self._event, self._capacity, self.lost)
        if self._failure is not None:
            raise self._failure
        if self._is_over:
            raise StopAsyncIteration

    # -------------------------------------------------------- for the producer

    @property
    def is_full(self) -> bool:
        """Whether time must wait for space in the buffer."""
        return (
            self._on_full == "wait"
            and not self._is_over
            and len(self._buffer) + self._processing >= self._capacity
        )

    def record(self, record: Mapping[str, Any]) -> None:
        """Add the occurrence in a record of the trace, if it is of this event."""
        if without_attempts(record["name"]) == self._event:
            self.push(occurrence_in(record))

    def push(self, occurrence: Occurrence) -> None:
        """Add an occurrence; those of a single instant may exceed the capacity."""
        if self._on_full == "fail" and (self.lost or len(self._buffer) >= self._capacity):
            self.lost += 1  # from the first loss on, so that the sequence has no gaps
            return
        if self._on_full == "drop_oldest" and len(self._buffer) >= self._capacity:
            self._buffer.popleft()
            self.lost += 1
        self._buffer.append(occurrence)
        self._more.notify_all()

    def end(self, failure: Exception | None = None) -> None:
        """End the iteration after the buffered occurrences.

        Args:
            failure: Exception to raise at the end, if any.
        """
        self._is_over, self._failure = True, failure
        self._more.notify_all()


@asynccontextmanager
async def open_subscription(
    readers: Readers, name: str, capacity: int, on_full: OnFull
) -> AsyncIterator[EventSubscription]:
    """Subscribe to an event of a run in this process while a block lasts.

    Args:
        readers: Readers of the trace of the run.
        name: Name of the event in the trace.
        capacity: Capacity of the buffer.
        on_full: Policy for a full buffer.
    """
    subscription = EventSubscription(name, capacity, on_full, readers.moved)
    readers.follow(subscription)
    try:
        yield subscription
    finally:
        subscription.end()
        readers.unfollow(subscription)
