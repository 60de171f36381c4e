"""Simulated time: the time of a simulator or a played bag, from `/clock`."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import TaskGroup, TaskStatus

from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Qos, Reliability
from seoro.concurrency.condition import Condition
from seoro.errors import UsageError

TOPIC: Final = "/clock"
TYPE: Final = "rosgraph_msgs/msg/Clock"
CLOCK_QOS: Final = Qos(Reliability.BEST_EFFORT, depth=1)  # profile of ROS 2 for clocks

SECOND: Final = 1_000_000_000  # [ns]
HISTORY: Final = 1000  # number of past times, for messages that arrived earlier
MIN_JUMP: Final = 10 * SECOND  # [ns] in one step forward that count as a jump, unless the clock runs fast:
MAX_RATE: Final = 100  # times the rate of this machine's clock; no simulation is faster
FIRST_TIMEOUT: Final = 1.0  # [s] to wait for the first time of a published clock

Note = Callable[[str], None]


class SimClock:
    """Latest time received on `/clock`.

    Args:
        on_note: Called with both times when the time jumps.
        on_back: Called when the time was set back.

    Attributes:
        jumps: Number of jumps.
        changes: Notified of each new time.
    """

    def __init__(self, on_note: Note, on_back: Callable[[], None] = lambda: None) -> None:
        self.jumps = 0
        self.changes = Condition()
        self._on_note = on_note
        self._on_back = on_back
        self._history: deque[tuple[int, int]] = deque(maxlen=HISTORY)  # arrival on this machine, and time [ns]
        self._started = anyio.Event()

    @property
    def now(self) -> int:
        """Latest time [ns]; see `wait_started`."""
        assert self._history, "the clock is waited for"
        return self._history[-1][1]

    @property
    def has_started(self) -> bool:
        """Whether a time was received."""
        return bool(self._history)

    async def wait_started(self) -> None:
        """Wait for the first time."""
        await self._started.wait()

    def at(self, arrived: int) -> int:
        """Return the time [ns] at an arrival, given by the clock of this machine [ns]; see `wait_started`."""
        return next((time for when, time in reversed(self._history) if when <= arrived), self._history[0][1])

    def set(self, now: int, arrived: int) -> None:
        """Set the time [ns] that arrived at a time of this machine's clock [ns]."""
        if self._history:
            self._detect_jump(now, arrived)
        self._history.append((arrived, now))
        self._started.set()
        self.changes.notify_all()

    async def follow(self, subscription: Subscription) -> None:
        """Set the time from each message, until the subscription ends."""
        async for received, message in subscription.decoded(self._on_note):
            self.set(message.clock.sec * SECOND + message.clock.nanosec, received.arrived)

    def _detect_jump(self, now: int, arrived: int) -> None:
        when, before = self._history[-1]
        if before <= now <= before + max(MIN_JUMP, MAX_RATE * (arrived - when)):
            return
        self.jumps += 1
        direction = "back" if now < before else "ahead"
        self._on_note(f"{TOPIC} jumped {direction} from {before / SECOND:.3f} s to {now / SECOND:.3f} s")
        self._history.clear()
        if now < before:
            self._on_back()


class MachineClock:
    """The monotonic clock of this machine; see `contracts.ros2.RosClock`."""

    jumps = 0

    def now(self) -> float:
        """Return the present time [s]."""
        return time.monotonic()

    def at(self, arrived: float) -> float:
        """Return the present time [s]."""
        return self.now()

    async def wait_until(self, moment: float) -> None:
        """Wait until a time [s]."""
        await anyio.sleep(max(0.0, moment - self.now()))


@dataclass(frozen=True)
class _User:
    note: Note
    on_back: Callable[[], None]


class SharedClock:
    """Time of a system: that of `/clock` if it is published, else that of this machine.

    `/clock` is followed while the clock has users. Only one user is notified of a jump.

    Args:
        node: Subscribing node.
        tasks: Task group of the subscription.
    """

    def __init__(self, node: RosNode, tasks: TaskGroup) -> None:
        self._node = node
        self._tasks = tasks
        self._users: list[_User] = []
        self._clock = self._new_clock()
        self._following = anyio.CancelScope()

    @property
    def jumps(self) -> int:
        """Number of jumps."""
        return self._clock.jumps

    def now(self) -> float | None:
        """Return the present time [s]; None before the first clock message."""
        return self.at(time.time())

    def at(self, arrived: float) -> float | None:
        """Return the time [s] at an arrival, given by the clock of this machine [s].

        It is the time of this machine if `/clock` has no publisher, and None before the first clock message.
        """
        if self._clock.has_started:
            return self._clock.at(round(arrived * SECOND)) / SECOND
        return None if self._is_published else arrived

    async def wait_until(self, moment: float) -> None:
        """Wait until a time [s], or until the time jumps."""
        jumps = self.jumps
        while self.jumps == jumps and ((now := self.now()) is None or now < moment):
            if now is None or self._clock.has_started:
                await self._clock.changes.wait()
            else:
                with anyio.move_on_after(moment - now):
                    await self._clock.changes.wait()

    @asynccontextmanager
    async def using(self, note: Note, on_back: Callable[[], None] = lambda: None) -> AsyncIterator[SharedClock]:
        """Follow the clock during the block; wait a moment for the first time of a published clock.

        Args:
            note: Called with jumps, unless another user is notified.
            on_back: Called when the time was set back.
        """
        user = _User(note, on_back)
        self._users.append(user)
        try:
            if len(self._users) == 1:
                self._following, self._clock = anyio.CancelScope(), self._new_clock()
                await self._tasks.start(self._follow)
            if self._is_published:
                with anyio.move_on_after(FIRST_TIMEOUT):
                    await self._clock.wait_started()
            yield self
        finally:
            self._users.remove(user)
            if not self._users:
                self._following.cancel()

    @property
    def _is_published(self) -> bool:
        return bool(self._node.graph.publishers(TOPIC))

    def _new_clock(self) -> SimClock:
        return SimClock(self._note, self._set_back)

    def _note(self, text: str) -> None:
        if self._users:
            self._users[0].note(text)

    def _set_back(self) -> None:
        for user in self._users:
            user.on_back()

    async def _follow(self, *, task_status: TaskStatus[None] = TASK_STATUS_IGNORED) -> None:
        clock = self._clock
        with self._following:
            try:
                async with self._node.subscribing(TOPIC, TYPE, CLOCK_QOS) as subscription:
                    task_status.started()
                    await clock.follow(subscription)
            except UsageError as error:  # the topic has another type
                self._note(str(error))
                task_status.started()
