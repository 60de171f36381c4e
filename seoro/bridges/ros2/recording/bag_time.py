"""The times at which a run observes a bag: by the bag alone, beside a simulator, or beside real robots."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Protocol

from anyio import CancelScope, move_on_after
from anyio.abc import TaskGroup

from seoro.bridges.ros2.recording.bag_system import BagSystem
from seoro.bridges.ros2.recording.reader import Bag
from seoro.errors import BackendLost
from seoro.runtime.contracts.backends import EventHandler, LossHandler
from seoro.runtime.contracts.ros2 import RobotNames


class BagTime:
    """Time server of a run whose clock is the bag.

    Args:
        system: The bag.
    """

    def __init__(self, system: BagSystem) -> None:
        self._system = system

    async def advance(self, until: float) -> float:
        """Deliver the next messages, if their time is at most `until` [s since the start of the bag]."""
        coming = self._system.next_time()
        reached = until if coming is None else min(coming, until)
        self._system.deliver(reached)
        return reached


class Simulator(Protocol):
    """A simulator whose time advances on request."""

    async def advance(self, until: float) -> float:
        """Simulate until `until` [s], or until an earlier event; return the reached time [s]."""


class SimulatedTime:
    """Time server of a run with a simulator, beside which a bag begins with the run.

    Args:
        simulator: The simulator, which is the clock. Messages arrive at the end of its steps.
        system: The bag.
    """

    def __init__(self, simulator: Simulator, system: BagSystem) -> None:
        self._simulator = simulator
        self._system = system

    async def advance(self, until: float) -> float:
        """Simulate until `until` [s since the start of the run], or until the next message."""
        coming = self._system.next_time()
        if coming is not None and coming <= self._system.time:  # at the start of the bag, or after its end
            self._system.deliver(self._system.time)
            return self._system.time
        reached = await self._simulator.advance(until if coming is None else min(coming, until))
        self._system.deliver(reached)
        return reached


class PlayedBag(BagSystem):
    """A bag beside real robots, which begins with the run and goes on by the clock of this machine.

    Args:
        bag: The bag.
        robots: See `BagSystem`.
        tasks: Task group of the run.
    """

    def __init__(self, bag: Bag, robots: Mapping[str, RobotNames], tasks: TaskGroup) -> None:
        super().__init__(bag, robots, is_alone=False)
        self._tasks = tasks
        self._playing = CancelScope()

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """See `Backend`."""
        await super().start_run(on_event, on_lost)
        self._tasks.start_soon(self._play, on_lost)

    async def end_run(self) -> None:
        """Deliver no more messages."""
        self._playing.cancel()

    async def _play(self, on_lost: LossHandler) -> None:
        """Deliver messages at their times, until the run ends."""
        begin = time.monotonic()
        with self._playing:
            try:
                while True:
                    await self._wait_for_next(begin)
                    self.deliver(time.monotonic() - begin)
            except BackendLost as error:
                on_lost(error)

    async def _wait_for_next(self, begin: float) -> None:
        """Wait until the next message is due, also if observers come meanwhile."""
        while (coming := self.next_time()) is None or begin + coming > time.monotonic():
            left = None if coming is None else begin + coming - time.monotonic()
            with move_on_after(left):
                await self.changed.wait()
