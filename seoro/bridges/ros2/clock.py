"""The time that a simulator, or a bag that is played, tells on `/clock`."""

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
from seoro.changes import Changes
from seoro.errors import BackendError, InvalidUse

TOPIC: Final = "/clock"
TYPE: Final = "rosgraph_msgs/msg/Clock"
CLOCK_QOS: Final = Qos(Reliability.BEST_EFFORT, depth=1)  # as ROS 2 has it for clocks

SECOND: Final = 1_000_000_000  # [ns]
KEPT: Final = 1000  # times that have been told, to say what it was when something arrived
AHEAD: Final = 10 * SECOND  # [ns] at once that are a jump, if they are also
FASTEST: Final = 100  # times as much as what has passed here: no simulation is meant to be faster
FIRST_WITHIN: Final = 1.0  # [s] until a clock that there is has told a time

Note = Callable[[str], None]


def _nothing() -> None:
    """Nobody minds that time was set back."""


class SimClock:
    """What `/clock` tells; the time is the last one that has arrived.

    Args:
        on_note: Is told when time jumps, with both times.
        on_back: Called when time was set back.

    Attributes:
        jumps: How often it has jumped.
        changes: Told of each time that arrives.
    """

    def __init__(self, on_note: Note, on_back: Callable[[], None] = _nothing) -> None:
        self.jumps = 0
        self.changes = Changes()
        self._on_note = on_note
        self._on_back = on_back
        self._told: deque[tuple[int, int]] = deque(maxlen=KEPT)  # when by this machine, and the time [ns]
        self._started = anyio.Event()

    @property
    def now(self) -> int:
        """[ns]; there has to be one (`wait_started`)."""
        assert self._told, "the clock is waited for"
        return self._told[-1][1]

    @property
    def has_started(self) -> bool:
        """Whether there is a time."""
        return bool(self._told)

    async def wait_started(self) -> None:
        """Wait for the first time."""
        await self._started.wait()

    def at(self, arrived: int) -> int:
        """The time [ns] when something arrived, by the clock of this machine [ns]; there has to be one."""
        return next((told for when, told in reversed(self._told) if when <= arrived), self._told[0][1])

    def take(self, now: int, arrived: int) -> None:
        """Take over a time [ns] that has arrived, by the clock of this machine [ns]."""
        if self._told:
            self._look_for_jump(now, arrived)
        self._told.append((arrived, now))
        self._started.set()
        self.changes.tell()

    async def follow(self, subscription: Subscription) -> None:
        """Take over what arrives, until the subscription ends."""
        noted = False
        async for received in subscription:
            try:
                clock = subscription.decode(received).clock
            except (BackendError, InvalidUse) as error:
                if not noted:
                    self._on_note(str(error))
                noted = True
                continue
            self.take(clock.sec * SECOND + clock.nanosec, received.arrived)

    def _look_for_jump(self, now: int, arrived: int) -> None:
        when, before = self._told[-1]
        if before <= now <= before + max(AHEAD, FASTEST * (arrived - when)):
            return
        self.jumps += 1
        way = "back" if now < before else "ahead"
        self._on_note(f"{TOPIC} jumped {way} from {before / SECOND:.3f} s to {now / SECOND:.3f} s")
        self._told.clear()
        if now < before:
            self._on_back()


@dataclass(frozen=True)
class _User:
    note: Note
    on_back: Callable[[], None]


class SharedClock:
    """The time of a system: that of `/clock` if there is one, else that of this machine.

    `/clock` is followed for as long as anybody needs it, and only one of those is told of a jump.

    Args:
        node: Subscribes.
        tasks: Where it is followed.
    """

    def __init__(self, node: RosNode, tasks: TaskGroup) -> None:
        self._node = node
        self._tasks = tasks
        self._users: list[_User] = []
        self._clock = self._made()
        self._following = anyio.CancelScope()

    @property
    def jumps(self) -> int:
        """How often it has jumped."""
        return self._clock.jumps

    def at(self, arrived: float) -> float | None:
        """The time [s] when something arrived, by the clock of this machine [s].

        It is that of the machine if nobody publishes `/clock`, and None if that has told nothing yet.
        """
        if self._clock.has_started:
            return self._clock.at(round(arrived * SECOND)) / SECOND
        return None if self._is_there else arrived

    async def wait_until(self, moment: float) -> None:
        """Wait until it is so late [s], or the time jumps."""
        jumps = self.jumps
        while self.jumps == jumps and ((now := self.at(time.time())) is None or now < moment):
            if now is None or self._clock.has_started:
                await self._clock.changes.wait()
            else:
                with anyio.move_on_after(moment - now):
                    await self._clock.changes.wait()

    @asynccontextmanager
    async def used(self, note: Note, on_back: Callable[[], None] = _nothing) -> AsyncIterator[SharedClock]:
        """Need it for as long as the block lasts; waits a moment for the first time of a clock that there is.

        Args:
            note: Told of jumps, unless somebody else is.
            on_back: Called when time was set back.
        """
        user = _User(note, on_back)
        self._users.append(user)
        try:
            if len(self._users) == 1:
                self._following, self._clock = anyio.CancelScope(), self._made()
                await self._tasks.start(self._follow)
            if self._is_there:
                with anyio.move_on_after(FIRST_WITHIN):
                    await self._clock.wait_started()
            yield self
        finally:
            self._users.remove(user)
            if not self._users:
                self._following.cancel()

    @property
    def _is_there(self) -> bool:
        return bool(self._node.graph.publishers(TOPIC))

    def _made(self) -> SimClock:
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
            except InvalidUse as error:  # it is of another type
                self._note(str(error))
                task_status.started()
