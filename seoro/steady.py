"""A clock that nobody can set: it counts on from the time of day at which the process started."""

from __future__ import annotations

import time
from typing import Final

# On Linux, this clock also counts while the machine is suspended.
_CLOCK: Final = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)


def age_ns() -> int:
    """Time since the start of this process [ns], whatever happens to the time of day."""
    return time.clock_gettime_ns(_CLOCK) - _STARTED


def steady_ns() -> int:
    """Time of day [ns since 1970] as it was when the process started, and counted on since."""
    return _EPOCH + age_ns()


_STARTED: Final = time.clock_gettime_ns(_CLOCK)
_EPOCH: Final = time.time_ns()
