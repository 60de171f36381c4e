"""An emergency stop on its way to the guard of a bridge, whatever the event loop of the bridge does meanwhile."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Collection


class Alarm:
    """The robots of emergency stops that the bridge has not carried out yet; for any thread.

    Attributes:
        when_changed: Called when they have changed.
    """

    def __init__(self) -> None:
        self.when_changed: Callable[[], None] = lambda: None
        self._stops: Counter[str] = Counter()  # of each robot
        self._lock = threading.Lock()

    @property
    def robots(self) -> frozenset[str]:
        """Names of the robots that are to be stopped."""
        with self._lock:
            return frozenset(+self._stops)

    def set(self, robots: Collection[str], is_on: bool) -> None:
        """Note that robots are to be stopped in an emergency, or that the bridge has done so."""
        with self._lock:
            if is_on:
                self._stops.update(robots)
            else:
                self._stops.subtract(robots)
        self.when_changed()
