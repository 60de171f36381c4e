"""Outages of a connection, during which messages may have been missed."""

from __future__ import annotations

import math
import time


class Outages:
    """Outages of one connection, reported by Zenoh's threads and read by the event loop.

    Args:
        is_connected: Whether the connection is established now.
    """

    def __init__(self, is_connected: bool) -> None:
        self._connections = int(is_connected)
        self._last = -math.inf  # end of the latest outage, by `time.monotonic`

    def change(self, is_connected: bool) -> None:
        """Record that a connection was made or lost; one of several connections is enough."""
        if is_connected and not self._connections:
            self._last = time.monotonic()
        self._connections = max(0, self._connections + (1 if is_connected else -1))

    def since(self, moment: float) -> bool:
        """Return whether the connection was lost at any time since a moment.

        Args:
            moment: The moment, by `time.monotonic` [s].
        """
        return not self._connections or self._last > moment
