"""Detection of blocking code in actions: how long each step holds the event loop, and where.

During a step nothing else runs, and timers are late. A normal step takes microseconds; a long one calls blocking
code. The warning names the lines between which it blocks.

A step may also be slow because the thread waits for a processor, or because Python collects garbage. Both are
subtracted as far as the operating system reports them.
"""

from __future__ import annotations

import gc
import inspect
import os
import resource
import sys
import threading
import time
from collections.abc import Callable, Coroutine
from contextlib import suppress
from pathlib import Path
from types import CodeType
from typing import Any, NamedTuple

LIMIT = 0.1  # [s] for a step
_RENEWAL = 0.02  # [s]; maximum age of a reading at the start of a step
_LONGEST = 100  # [bytes] of the kernel's statistics of a thread: three numbers


class _Reading(NamedTuple):
    """Resource usage of the thread so far."""

    processor: float  # [s] of processor time
    delay: float  # [s] of waiting for a processor
    rests: int  # number of voluntary context switches
    collections: int  # number of full garbage collections


class ThreadUsage:
    """Measures the step's own part of its duration. One per run, in the thread of its event loop."""

    def __init__(self) -> None:
        self._taken = -1.0
        self._reading = _Reading(0.0, 0.0, 0, 0)
        self._delays: int | None = None  # a file, open while the run lasts

    def begin(self) -> None:
        """Start measuring, in this thread."""
        with suppress(OSError):  # not supported by every kernel
            self._delays = os.open("/proc/thread-self/schedstat", os.O_RDONLY | os.O_CLOEXEC)

    def end(self) -> None:
        """Stop measuring."""
        if self._delays is not None:
            os.close(self._delays)
            self._delays = None

    def renew(self, now: float) -> None:
        """Read the usage at the start of a step [s, monotonic], unless the last reading is recent.

        After an idle time every step needs a new reading. The file stays open because opening it took half of the
        reaction time.
        """
        if now - self._taken > _RENEWAL:
            self._taken = now
            self._reading = self._read()

    def of(self, held: float) -> float:
        """Return how much of the duration [s] of a step was computation or its own waiting."""
        before, after = self._reading, self._read()
        if after.collections > before.collections:
            return 0.0
        if after.rests == before.rests:
            return min(held, after.processor - before.processor)
        return held - (after.delay - before.delay)

    def _read(self) -> _Reading:
        used = resource.getrusage(resource.RUSAGE_THREAD)
        delay = 0
        if self._delays is not None:
            with suppress(OSError, ValueError, IndexError):
                delay = int(os.pread(self._delays, _LONGEST, 0).split()[1])
        collections = gc.get_stats()[-1]["collections"]
        return _Reading(used.ru_utime + used.ru_stime, delay * 1e-9, used.ru_nvcsw, collections)


class Meter:
    """Measures the steps of one action.

    Args:
        share: Thread usage of the run.
        blocked: Called after a long step, with its duration [s] and its place in Python code.
    """

    __slots__ = ("_began", "_blocked", "_coroutine", "_excused", "_handed_over", "_has_begun", "_line", "_share")

    def __init__(self, share: ThreadUsage, blocked: Callable[[float, str], None]) -> None:
        self._share = share
        self._blocked = blocked
        self._coroutine: Any = None
        self._line = 0
        self._has_begun = False
        self._began = 0.0
        self._handed_over = 0.0
        self._excused = 0.0

    def attach(self, coroutine: Coroutine[Any, Any, None]) -> None:
        """Set the coroutine of the action."""
        self._coroutine = coroutine
        self._line = self._coroutine.cr_code.co_firstlineno

    def begin(self) -> None:
        """Start a step."""
        if self._has_begun:  # before that it is at its first line; accessing a frame would create one
            self._line = self._coroutine.cr_frame.f_lineno
        self._has_begun = True
        self._handed_over = self._excused = 0.0
        self._began = time.monotonic()
        self._share.renew(self._began)

    def hand_over(self) -> None:
        """Exclude the following work of the runtime, until `take_back` or the end of the step."""
        self._handed_over = time.monotonic()

    def take_back(self) -> None:
        """Resume measuring the action."""
        if self._handed_over:
            self._excused += time.monotonic() - self._handed_over
            self._handed_over = 0.0

    def end(self) -> None:
        """End a step, unless it has ended."""
        if not self._began:
            return
        held = (self._handed_over or time.monotonic()) - self._began - self._excused
        if held > LIMIT and (held := self._share.of(held)) > LIMIT:
            code, frame = self._coroutine.cr_code, self._coroutine.cr_frame
            last = "its end" if frame is None else frame.f_lineno
            until = "" if last == self._line else f" to {last}"
            self._blocked(held, f"`{code.co_name}`, {_shown_file(code)}:{self._line}{until}")
        self._began = 0.0

    @property
    def place(self) -> str:
        """Current location of the action, for messages; empty after its end."""
        frame = self._coroutine.cr_frame
        return "" if frame is None else f"{_shown_file(frame.f_code)}:{frame.f_lineno}"


def place_of_thread(thread: threading.Thread, function: Callable[..., Any]) -> str:
    """Return the current line of a thread in a function that it called; empty if it has left the function."""
    code = getattr(inspect.unwrap(function), "__code__", None)
    frame = sys._current_frames().get(thread.ident or 0)
    while frame is not None and frame.f_code is not code:
        frame = frame.f_back
    return "" if frame is None else f"{_shown_file(frame.f_code)}:{frame.f_lineno}"


def _shown_file(code: CodeType) -> str:
    """Return the file of code for messages: relative to the working directory if inside."""
    path = Path(code.co_filename)
    with suppress(ValueError, OSError):
        path = path.relative_to(Path.cwd())
    return str(path)
