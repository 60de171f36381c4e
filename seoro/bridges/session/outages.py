"""Outages of a connection: whether something that was waited for may have been missed."""

from __future__ import annotations

import math
import time


class Outages:
    """The outages of one connection. Zenoh's threads report them, and the event loop reads them.

    Args:
        is_connected: Whether the connection holds now.
    """

    def __init__(self, is_connected: bool) -> None:
        self._connections = int(is_connected)
        self._last = -math.inf  # end of the latest outage, by `time.monotonic`

    def change(self, is_connected: bool) -> None:
        """Report that a connection was made or lost; of several connections, one is enough."""
        if is_connected and not self._connections:
            self._last = time.monotonic()
        self._connections = max(0, self._connections + (1 if is_connected else -1))

    def since(self, moment: float) -> bool:
        """Return whether the connection was lost at any time since a moment.

        Args:
            moment: The moment, by `time.monotonic` [s].
        """
        return not self._connections or self._last > moment
