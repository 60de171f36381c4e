"""Signals that stop a campaign."""

from __future__ import annotations

import signal
import sys

import anyio

from seoro.campaign.session import Campaign


class Interruption:
    """Stops a campaign at the first signal, and drops it at the second.

    Args:
        campaign: The campaign.
    """

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self.has_come = False

    async def listen(self, scope: anyio.CancelScope) -> None:
        """Wait for signals."""
        with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
            async for _ in signals:
                if self.has_come:
                    scope.cancel()
                    return
                self.has_come = True
                print("stopping active runs; press again to stop at once", file=sys.stderr, flush=True)
                self._campaign.stop()
