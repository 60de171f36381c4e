"""How far the clock of an executor is from ours, as NTP finds out: from when a request left and arrived, and when
its answer left and arrived (RFC 5905, section 8). Of some exchanges, the quickest counts: it leaves least doubt.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.wire.message import Empty

EXCHANGES: Final = 4
NOTABLE: Final = 0.1  # [s] by which clocks may differ


@dataclass(frozen=True)
class Clock:
    """A clock, against ours.

    Args:
        offset: How far it is ahead [s].
        round_trip: How long the quickest exchange was on its way [s]; the offset is wrong by half of it at most.
    """

    offset: float
    round_trip: float

    def __str__(self) -> str:
        size = abs(self.offset)
        shown = f"{size:.1f} s" if size >= 1.0 else f"{1000.0 * size:.1f} ms"
        return f"{shown} {'ahead' if self.offset > 0.0 else 'behind'}"

    @property
    def is_wrong(self) -> bool:
        """Whether it is further from ours than anybody would expect, beyond doubt."""
        return abs(self.offset) - self.round_trip / 2.0 > NOTABLE


def compare(left: float, took: float, received: float, sent: float) -> Clock:
    """The clock of somebody who was asked, by one exchange.

    Args:
        left: When the request left [s since 1970], by our clock.
        took: How long it took until the answer was here [s].
        received: When the request arrived, by theirs.
        sent: When the answer left, by theirs.
    """
    offset = ((received - left) + (sent - (left + took))) / 2.0
    return Clock(offset, max(took - (sent - received), 0.0))


async def describe(executor: Executor, exchanges: int = EXCHANGES) -> tuple[wire.ExecutorInfo, Clock | None]:
    """What an executor is, and its clock; None for the clock of one that is too old to tell.

    Raises:
        BackendError: It is gone.
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
