"""Offset of the clock of an executor, measured as by NTP (RFC 5905, section 8).

Each exchange has four times: departure and arrival of the request and of the reply. The exchange with the shortest
round trip counts, since it has the smallest uncertainty.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.wire.message import Empty

EXCHANGES: Final = 4
NOTABLE: Final = 0.1  # [s] accepted offset of a clock


@dataclass(frozen=True)
class Clock:
    """Offset of a clock from ours.

    Args:
        offset: Time by which the clock is ahead [s].
        round_trip: Shortest round trip [s]; the uncertainty of the offset is half of it.
    """

    offset: float
    round_trip: float

    def __str__(self) -> str:
        size = abs(self.offset)
        shown = f"{size:.1f} s" if size >= 1.0 else f"{1000.0 * size:.1f} ms"
        return f"{shown} {'ahead' if self.offset > 0.0 else 'behind'}"

    @property
    def is_wrong(self) -> bool:
        """Whether the offset certainly exceeds `NOTABLE`."""
        return abs(self.offset) - self.round_trip / 2.0 > NOTABLE


def compare(left: float, took: float, received: float, sent: float) -> Clock:
    """Return the offset of a server's clock from one exchange.

    Args:
        left: Departure of the request [s since 1970], by our clock.
        took: Time until the arrival of the reply [s].
        received: Arrival of the request, by the server's clock.
        sent: Departure of the reply, by the server's clock.
    """
    offset = ((received - left) + (sent - (left + took))) / 2.0
    return Clock(offset, max(took - (sent - received), 0.0))


async def describe(executor: Executor, exchanges: int = EXCHANGES) -> tuple[wire.ExecutorInfo, Clock | None]:
    """Return the description of an executor, and its clock (None for old versions).

    Raises:
        BackendError: The executor does not reply.
    """
    best: Clock | None = None
    for _ in range(exchanges):
        began, left = time.perf_counter(), time.time()
        info = await executor.ask(wire.DESCRIBE, Empty())
        took = time.perf_counter() - began
        if info.received is None or info.sent is None:
            break
        found = compare(left, took, info.received, info.sent)
        if best is None or found.round_trip < best.round_trip:
            best = found
    return info, best
