"""Time of day that is not affected by clock changes after the start of the process."""

from __future__ import annotations

import time
from typing import Final

# On Linux, this clock also counts while the machine is suspended.
_CLOCK: Final = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)


def age_ns() -> int:
    """Return the time since the start of this process [ns], unaffected by clock changes."""
    return time.clock_gettime_ns(_CLOCK) - _STARTED


def steady_ns() -> int:
    """Return the time of day [ns since 1970], unaffected by clock changes since the start of the process."""
    return _EPOCH + age_ns()


_STARTED: Final = time.clock_gettime_ns(_CLOCK)
_EPOCH: Final = time.time_ns()
