"""Precise alarms: a Linux timer (`timerfd`) as a file that the event loop watches.

The event loops of asyncio and uvloop round sleeps up to milliseconds, and may be two milliseconds late. A
`timerfd` is precise to a fraction of that, and never early. It is created shortly before its time only,
since creating and closing one is as expensive as a wake-up by a message. Most alarms of time limits never ring.
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
SIZE_OF_COUNT = 8  # [bytes] read from an expired timer
NEAR = 0.02  # [s] before the alarm, a precise timer replaces that of the event loop


class _TimeSpec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_longlong), ("tv_nsec", ctypes.c_long))


class _TimerSpec(ctypes.Structure):
    _fields_ = (("it_interval", _TimeSpec), ("it_value", _TimeSpec))


@contextmanager
def alarm(at: float, ring: Callable[[], None]) -> Generator[None]:
    """Set an alarm on the running event loop during the block.

    Args:
            at: Time of the alarm, on the clock of `time.monotonic` [s]; at once if in the past.
            ring: Called once, in the loop. If no file descriptor is free, a timer of the loop calls it.
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
    """Set a Linux timer during the block.

    Raises:
        OSError: Too many files are open.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    file = libc.timerfd_create(CLOCK_MONOTONIC, TFD_FLAGS)
    if file < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"cannot create a timer: {os.strerror(number)}")
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
