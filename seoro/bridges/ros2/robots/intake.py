"""Messages of the topics of a robot, read in batches.

A wake-up of the event loop costs several times as much as a message. So messages wait until a request needs them,
and 0.2 s at most; while a task waits for a change, they are read as they arrive.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Final, NamedTuple

from seoro.bridges.ros2.topics import ReceivedPayload, Subscription
from seoro.concurrency.condition import Condition

PERIOD: Final = 0.2  # [s] between two readings while no task waits


class _Reader(NamedTuple):
    subscription: Subscription
    take: Callable[[ReceivedPayload], None]


class Intake:
    """Unread messages of subscriptions. For one event loop.

    Attributes:
        arrivals: Notified of messages, after all that have arrived are taken.
    """

    def __init__(self) -> None:
        self.arrivals = Condition(self._hurry)
        self._readers: list[_Reader] = []
        self._due = asyncio.Event()

    def add(self, subscription: Subscription, take: Callable[[ReceivedPayload], None]) -> None:
        """Read a subscription from now on: `take` is called with each message."""
        self._readers.append(_Reader(subscription, take))
        self._hurry()

    def read(self) -> None:
        """Take all messages that have arrived."""
        has_read = False
        for subscription, take in self._readers:
            for _ in range(subscription.unread):
                if (received := subscription.receive_nowait()) is not None:
                    has_read = True
                    take(received)
        if has_read:
            self.arrivals.notify_all()

    async def run(self) -> None:
        """Read messages, without end."""
        loop = asyncio.get_running_loop()
        while True:
            self._due.clear()
            self.read()
            if self.arrivals.is_awaited:
                for reader in self._readers:
                    reader.subscription.on_arrival(self._hurry)
                await self._due.wait()
                continue
            timer = loop.call_later(PERIOD, self._hurry)
            try:
                await self._due.wait()
            finally:
                timer.cancel()

    def _hurry(self) -> None:
        self._due.set()
