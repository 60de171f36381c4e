"""Emergency stops of a simulator, on their way from a thread of their own to the main one.

Time is held before anything else, which the main thread sees between two batches of physics steps. Then it stops
the robots, all or those that are named, before it carries out another request. A request that takes long, such as
loading a world, lets no time pass: a stop is acknowledged meanwhile.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

from seoro.bridges.wire import EmergencyStop, EmergencyStopped
from sim_nodes.leasing import Leasing
from sim_nodes.simulator import Simulator

BUSY: Final = 0.2  # [s] after which a stop is acknowledged by a node that is busy, whose time is held


@dataclass(frozen=True)
class _Stop:
    began: float  # [s] of the machine's monotonic clock
    robots: tuple[str, ...]
    stopped: Future[EmergencyStopped] = field(default_factory=Future)


class Stops:
    """Emergency stops that the main thread has not seen yet.

    Args:
        simulator: Whose time is held.
        leasing: Stops its robots.
        wake: Wakes the main thread.
    """

    def __init__(self, simulator: Simulator, leasing: Leasing, wake: Callable[[], object]) -> None:
        self._simulator = simulator
        self._leasing = leasing
        self._wake = wake
        self._waiting: queue.SimpleQueue[_Stop] = queue.SimpleQueue()
        self._late: threading.Timer | None = None  # of the oldest that waits

    def stop(self, asked: EmergencyStop) -> Future[EmergencyStopped]:
        """Let nothing move from now on, or none of the named robots; from the thread of emergency stops.

        Raises:
            RequestRefused: None of the named robots is here.
        """
        began = time.monotonic()
        stop = _Stop(began, self._leasing.stop_from_now_on(asked))
        self._simulator.halt()
        self._waiting.put(stop)
        self._wake()
        if self._late is None or not self._late.is_alive():
            self._late = threading.Timer(BUSY, self._acknowledge, (stop,))
            self._late.daemon = True
            self._late.start()
        return stop.stopped

    def settle(self) -> bool:
        """Stop the robots, on the main thread, if there was a stop; returns whether there was one."""
        stops: list[_Stop] = []
        while not self._waiting.empty():
            stops.append(self._waiting.get())
        if not stops:
            return False
        self._leasing.stop_robots({robot for stop in stops for robot in stop.robots})
        for stop in stops:
            self._acknowledge(stop)
        return True

    def _acknowledge(self, stop: _Stop) -> None:
        took = time.monotonic() - stop.began
        with suppress(InvalidStateError):  # it was acknowledged
            stop.stopped.set_result(EmergencyStopped(stopped=stop.robots, took=took))
