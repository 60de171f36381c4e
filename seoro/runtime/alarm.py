"""An alarm that rings on time: a timer of Linux (`timerfd`), as a file that an event loop watches.

The event loops of asyncio and uvloop sleep for whole milliseconds, rounded up, up to two milliseconds too long.
A `timerfd` becomes readable at its time, to a fraction of that, and never before. It is made when the alarm is
about to ring: to make one and to take it back costs as much as a run does that a message wakes, and of runs that
wait for messages with a time limit, all but the last of the alarms never ring.
"""

from __future__ import annotations

import asyncio
import ctypes
import math
import os
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager

CLOCK_MONOTONIC = 1  # linux/time.h; that of `time.monotonic`
TFD_TIMER_ABSTIME = 1  # sys/timerfd.h
TFD_FLAGS = os.O_NONBLOCK | os.O_CLOEXEC  # TFD_NONBLOCK and TFD_CLOEXEC have the values of these
NANOSECONDS = 1_000_000_000  # in a second
SIZE_OF_COUNT = 8  # [bytes] of what is read from a timer that has expired
NEAR = 0.02  # [s] before its time, an alarm becomes an exact one; a loop is late by less, as a rule


class _TimeSpec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_longlong), ("tv_nsec", ctypes.c_long))


class _TimerSpec(ctypes.Structure):
    _fields_ = (("it_interval", _TimeSpec), ("it_value", _TimeSpec))


@contextmanager
def alarm(at: float, ring: Callable[[], None]) -> Generator[None]:
    """Within the block, an alarm is set on the running event loop.

    Args:
        at: When it rings, on the clock of `time.monotonic` [s]; at once if that has passed.
        ring: Called in the loop then, once. Where too many files are open for a timer, the loop has it ring.
    """
    loop = asyncio.get_running_loop()
    with ExitStack() as stack:

        def come_near() -> None:
            try:
                stack.enter_context(_exact(at, ring))
            except OSError:
                stack.callback(loop.call_later(at - time.monotonic(), ring).cancel)

        ahead = at - NEAR - time.monotonic()
        if ahead > 0:
            stack.callback(loop.call_later(ahead, come_near).cancel)
        else:
            come_near()
        yield


@contextmanager
def _exact(at: float, ring: Callable[[], None]) -> Generator[None]:
    """Within the block, a timer of Linux is set.

    Raises:
        OSError: Too many files are open.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    file = libc.timerfd_create(CLOCK_MONOTONIC, TFD_FLAGS)
    if file < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"the machine gives no timer: {os.strerror(number)}")
    loop = asyncio.get_running_loop()

    def expired() -> None:
        os.read(file, SIZE_OF_COUNT)
        ring()

    try:
        due = _TimeSpec(*divmod(max(1, math.ceil(at * NANOSECONDS)), NANOSECONDS))  # 0 would mean never
        once = _TimerSpec(_TimeSpec(0, 0), due)
        libc.timerfd_settime(file, TFD_TIMER_ABSTIME, ctypes.byref(once), None)
        loop.add_reader(file, expired)
        try:
            yield
        finally:
            loop.remove_reader(file)
    finally:
        os.close(file)
