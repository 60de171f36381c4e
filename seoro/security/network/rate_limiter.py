"""Rate limiter with a token bucket for each caller."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from typing import Final

MOST: Final = 1000  # callers with a bucket; the least recent one is dropped, as its bucket is full by then


class RateLimiter:
    """Limits the rate of each caller.

    Args:
        clock: Clock of any origin [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()  # tokens left, and when

    def acquire(self, caller: str, rate: float, burst: float) -> bool:
        """Consume a token; False if the caller is over its rate.

        Args:
            caller: Name of the caller.
            rate: Average rate [1/s].
            burst: Largest number of tokens.
        """
        now = self._clock()
        left, since = self._buckets.pop(caller, (burst, now))
        left = min(burst, left + (now - since) * rate)
        may = left >= 1.0
        self._buckets[caller] = (left - 1.0 if may else left, now)
        if len(self._buckets) > MOST:
            self._buckets.popitem(last=False)
        return may
