"""Emergency stops of a simulator, passed from their own thread to the main thread.

First, time is held, which the main thread notices between two batches of physics steps. It then stops all or the
named robots before any other request. A long request, such as loading a world, passes no time, so a stop is
acknowledged meanwhile.
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

from seoro.bridges.wire import EmergencyStop, StopAcknowledgement
from sim_nodes.leasing import Leasing
from sim_nodes.simulator import Simulator

BUSY: Final = 0.2  # [s] after which a busy node acknowledges a stop, because its time is held


@dataclass(frozen=True)
class _Stop:
    began: float  # [s] of the monotonic clock
    robots: tuple[str, ...]
    stopped: Future[StopAcknowledgement] = field(default_factory=Future)


class EmergencyStops:
    """Emergency stops that the main thread has not handled yet.

    Args:
        simulator: Simulator whose time is held.
        leasing: Leases, which stop robots.
        wake: Wakes the main thread.
    """

    def __init__(self, simulator: Simulator, leasing: Leasing, wake: Callable[[], object]) -> None:
        self._simulator = simulator
        self._leasing = leasing
        self._wake = wake
        self._waiting: queue.SimpleQueue[_Stop] = queue.SimpleQueue()
        self._late: threading.Timer | None = None  # of the oldest stop

    def stop(self, request: EmergencyStop) -> Future[StopAcknowledgement]:
        """Stop all robots, or the named ones; called on the thread of emergency stops.

        Raises:
            RequestRefused: None of the named robots is here.
        """
        began = time.monotonic()
        stop = _Stop(began, self._leasing.latch_stop(request))
        self._simulator.halt()
        self._waiting.put(stop)
        self._wake()
        if self._late is None or not self._late.is_alive():
            self._late = threading.Timer(BUSY, self._acknowledge, (stop,))
            self._late.daemon = True
            self._late.start()
        return stop.stopped

    def apply_pending(self) -> bool:
        """Stop the robots, on the main thread, if there are new stops; returns whether there were any."""
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
        with suppress(InvalidStateError):  # already acknowledged
            stop.stopped.set_result(StopAcknowledgement(stopped=stop.robots, took=took))
