"""`Channel` and `Subscription`: events as channels.

Contract:

- `channel.send(fields, past)` sends an occurrence in this instant; it is delivered at commit. Occurrences with an
  equal `key` in one instant are one. It is in the past of its sender.
- `with channel.subscribe(task) as subscription: occurrence = await subscription.receive()`; `async for` works too.
- A subscription receives occurrences from the instant in which it began, unless they are in its past; received
  occurrences join its past. Occurrences refused by its filter are not received, and take no step of the task.
- Occurrences of one instant have no order that a task can observe.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from itertools import count
from types import TracebackType
from typing import Any, Protocol, TypeAlias

from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import CausalPast, Task, Waiter

OnReceive: TypeAlias = "Callable[[Occurrence], bool]"
"""Called at commit with an occurrence; returns whether it counts, and joins the past."""

_numbers = count()


class Occurrence:
    """One occurrence of an event; an event object has the arguments as fields.

    Args:
        fields: Its arguments.
    """

    __slots__ = ("__weakref__", "cause", "fields", "number")

    def __init__(self, fields: Mapping[str, Any]) -> None:
        self.cause: int | None = None  # number of its record; see `CausalPast`
        self.number = next(_numbers)
        self.fields = fields


class Receiver(Protocol):
    """Destination of a channel."""

    @property
    def past(self) -> CausalPast:
        """Occurrences that it must not receive."""

    def deliver(self, occurrence: Occurrence) -> bool:
        """Receive an occurrence at commit; return whether it counts."""


class Channel:
    """A channel for occurrences of one event.

    Args:
        scheduler: Scheduler of the run.
        name: Name for messages, and for the order of messages in one delta cycle.
    """

    __slots__ = ("__weakref__", "_instant", "_pending", "_receivers", "_sent", "name", "scheduler")

    def __init__(self, scheduler: Scheduler, name: str) -> None:
        self.scheduler = scheduler
        self.name = name
        self._instant = -1
        self._pending: dict[str, Occurrence] = {}  # of this instant, by key
        self._sent: list[Occurrence] = []  # delivered in this instant
        self._receivers: dict[Receiver, None] = {}

    def send(self, fields: Mapping[str, Any], past: CausalPast, key: str = "") -> Occurrence | None:
        """Send an occurrence; it is delivered between this delta cycle and the next.

        Args:
            fields: Its arguments.
            past: Past of the sender; the occurrence is added.
            key: Distinguishes occurrences with different arguments.

        Returns:
            The occurrence if it is new; None if an equal one was sent in this instant.
        """
        self._begin_instant()
        equal = self._pending.get(key)
        if equal is not None:
            past.add(equal.number, self._instant)
            return None
        occurrence = self._pending[key] = Occurrence(fields)
        self.scheduler.send((self.name, key), partial(self._deliver, occurrence))
        past.add(occurrence.number, self._instant)
        return occurrence

    def subscribe(
        self, task: Task, past: CausalPast | None = None, on_receive: OnReceive | None = None
    ) -> Subscription:
        """Return a subscription, to be entered.

        Args:
            task: The receiver.
            past: Occurrences to ignore; by default, the past of the task.
            on_receive: Called with each occurrence, instead of `Subscription.receive`.
        """
        subscription = Subscription(task, past, on_receive)
        subscription.receive_from(self)
        return subscription

    def attach(self, receiver: Receiver) -> None:
        """Deliver to a receiver from now on, including occurrences already sent in this instant."""
        self._begin_instant()
        self._receivers[receiver] = None
        for occurrence in self._sent:
            self._offer(occurrence, receiver)

    def detach(self, receiver: Receiver) -> None:
        """Stop delivering to a receiver."""
        self._receivers.pop(receiver, None)

    def _deliver(self, occurrence: Occurrence) -> None:
        self._sent.append(occurrence)
        for receiver in tuple(self._receivers):
            if receiver in self._receivers:
                self._offer(occurrence, receiver)

    def _offer(self, occurrence: Occurrence, receiver: Receiver) -> None:
        past, instant = receiver.past, self._instant
        if past.contains(occurrence.number, instant):
            return
        scheduler = self.scheduler
        before, scheduler.cause = scheduler.cause, occurrence.cause
        if receiver.deliver(occurrence):
            past.add(occurrence.number, instant)
        scheduler.cause = before

    def _begin_instant(self) -> None:
        """Drop occurrences of earlier instants, which can no longer be received."""
        instant = self.scheduler.instant
        if self._instant != instant:
            self._instant = instant
            self._pending.clear()
            self._sent.clear()


class Subscription:
    """Subscription of one task to a channel or to several sources.

    Args:
        task: The receiver.
        past: Occurrences to ignore; by default, the past of the task.
        on_receive: Called with each occurrence, instead of `receive`.
        once: Whether it receives one occurrence only; others can be received later in their instant.
    """

    __slots__ = (
        "_buffer",
        "_closings",
        "_on_receive",
        "_once",
        "_source",
        "_task",
        "_waiter",
        "is_closed",
        "past",
        "received",
    )

    def __init__(
        self, task: Task, past: CausalPast | None = None, on_receive: OnReceive | None = None, once: bool = False
    ) -> None:
        self.past = task.past if past is None else past
        self.received = False  # whether any occurrence has counted
        self.is_closed = False
        self._task = task
        self._on_receive = on_receive
        self._once = once
        self._buffer: deque[Occurrence] | None = None
        self._waiter = Waiter(task) if on_receive is None else None
        self._closings: list[Callable[[], None]] | None = None
        self._source: Channel | None = None

    def __enter__(self) -> Subscription:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stop receiving."""
        self.is_closed = True
        if self._source is not None:
            self._source.detach(self)
        if self._closings is not None:
            closings, self._closings = self._closings, None
            for close in closings:
                close()

    def receive_from(self, channel: Channel) -> None:
        """Receive from a channel, until closed."""
        self._source = channel
        channel.attach(self)

    def on_close(self, act: Callable[[], None]) -> None:
        """Register a callback for `close`, such as one that detaches a source."""
        if self._closings is None:
            self._closings = []
        self._closings.append(act)

    def deliver(self, occurrence: Occurrence) -> bool:
        """Receive an occurrence at commit; return whether it counts."""
        if self.is_closed or (self._once and self.received):
            return False
        if self._on_receive is not None:
            counts = self._on_receive(occurrence)
            self.received = self.received or counts
            return counts
        self.received = True
        if self._buffer is None:
            self._buffer = deque()
        self._buffer.append(occurrence)
        assert self._waiter is not None
        self._task.scheduler.wake(self._waiter)
        return True

    async def receive(self) -> Occurrence:
        """Wait for an occurrence and return it; each takes a step."""
        assert self._waiter is not None, "`on_receive` receives the occurrences"
        waiter, scheduler = self._waiter, self._task.scheduler
        await scheduler.wait(waiter)
        assert self._buffer is not None
        if not self._once:
            self._waiter = Waiter(self._task)
            if len(self._buffer) > 1:
                scheduler.wake(self._waiter)
        return self._buffer.popleft()

    def __aiter__(self) -> Subscription:
        return self

    async def __anext__(self) -> Occurrence:
        return await self.receive()
