"""The time that a simulator tells on `/clock`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import anyio

from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Qos, Reliability

TOPIC: Final = "/clock"
TYPE: Final = "rosgraph_msgs/msg/Clock"
CLOCK_QOS: Final = Qos(Reliability.BEST_EFFORT, depth=1)  # as ROS 2 has it for clocks

SECOND: Final = 1_000_000_000  # [ns]


class SimClock:
    """Follows `/clock`; the time is the last one that has arrived.

    Args:
        on_note: Is told when time jumps back.
    """

    def __init__(self, on_note: Callable[[str], None]) -> None:
        self._on_note = on_note
        self._now: int | None = None
        self._started = anyio.Event()

    @property
    def now(self) -> int:
        """[ns]; there has to be one (`wait_started`)."""
        assert self._now is not None, "the clock is waited for"
        return self._now

    @property
    def has_started(self) -> bool:
        """Whether there is a time."""
        return self._now is not None

    async def wait_started(self) -> None:
        """Wait for the first time."""
        await self._started.wait()

    async def follow(self, subscription: Subscription) -> None:
        """Take over what arrives, until the subscription ends."""
        async for received in subscription:
            clock = subscription.decode(received).clock
            now = clock.sec * SECOND + clock.nanosec
            if self._now is not None and now < self._now:
                self._on_note(f"{TOPIC} jumped back from {self._now / SECOND:.3f} s to {now / SECOND:.3f} s")
            self._now = now
            self._started.set()
