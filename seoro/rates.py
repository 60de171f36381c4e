"""How often callers ask: each has a bucket of tokens, which fills with time."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from typing import Final

MOST: Final = (
    1000  # callers that are remembered; who was not there for longest is forgotten, with a bucket long full
)


class Rates:
    """How often each of many callers may do something.

    Args:
        clock: [s], of any origin.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()  # tokens that were left, and when

    def take(self, caller: str, rate: float, burst: float) -> bool:
        """Whether a caller may do it now.

        Args:
            caller: Who it is.
            rate: How often on average [1/s].
            burst: How often at once.
        """
        now = self._clock()
        left, since = self._buckets.pop(caller, (burst, now))
        left = min(burst, left + (now - since) * rate)
        may = left >= 1.0
        self._buckets[caller] = (left - 1.0 if may else left, now)
        if len(self._buckets) > MOST:
            self._buckets.popitem(last=False)
        return may
