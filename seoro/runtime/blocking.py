"""Blocking code in actions: how long each step of an action holds the event loop, and where.

While a step lasts nothing else can go on, and timers are late. A step of an ordinary action is over in
microseconds; one that takes long calls something that blocks, and what is told says between which lines that is.

A step may also take long because the machine lets the thread wait for a processor, or because Python collects
garbage in it. That is no fault of the action, and is subtracted as far as the machine tells.
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

LIMIT = 0.1  # [s] that a step may take
_RENEWAL = 0.02  # [s]; how old a reading is at most when a step begins
_LONGEST = 100  # [bytes] of what the machine tells of a thread: three numbers


class _Reading(NamedTuple):
    """What the thread has had of the machine so far."""

    processor: float  # [s] that it has computed
    delay: float  # [s] that it was ready to compute, and had no processor
    rests: int  # how often it has gone to sleep
    collections: int  # of all garbage


class Share:
    """Tells what part of a step was the step's own work. One for each run, in the thread of its loop."""

    def __init__(self) -> None:
        self._taken = -1.0
        self._reading = _Reading(0.0, 0.0, 0, 0)
        self._delays: int | None = None  # a file, open while the run lasts

    def begin(self) -> None:
        """The run begins, in this thread."""
        with suppress(OSError):  # not every kernel tells
            self._delays = os.open("/proc/thread-self/schedstat", os.O_RDONLY | os.O_CLOEXEC)

    def end(self) -> None:
        """The run is over."""
        if self._delays is not None:
            os.close(self._delays)
            self._delays = None

    def renew(self, now: float) -> None:
        """A step begins now [s, monotonic]; what is read is at most a moment older.

        What arrives after a while is answered by a step that reads: to open the file anew took half of the time
        of the answer.
        """
        if now - self._taken > _RENEWAL:
            self._taken = now
            self._reading = self._read()

    def of(self, held: float) -> float:
        """How much of the time [s] that the step took it has computed or waited for something of its own."""
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
        share: Of the run.
        blocked: Called after a step that was too long, with its length [s] and where in Python it was.
    """

    __slots__ = ("_began", "_blocked", "_coroutine", "_excused", "_handed_over", "_has_begun", "_line", "_share")

    def __init__(self, share: Share, blocked: Callable[[float, str], None]) -> None:
        self._share = share
        self._blocked = blocked
        self._coroutine: Any = None
        self._line = 0
        self._has_begun = False
        self._began = 0.0
        self._handed_over = 0.0
        self._excused = 0.0

    def attach(self, coroutine: Coroutine[Any, Any, None]) -> None:
        """This is the coroutine of the action."""
        self._coroutine = coroutine
        self._line = self._coroutine.cr_code.co_firstlineno

    def begin(self) -> None:
        """A step begins."""
        if self._has_begun:  # else it is at its first line; to ask for a frame makes one
            self._line = self._coroutine.cr_frame.f_lineno
        self._has_begun = True
        self._handed_over = self._excused = 0.0
        self._began = time.monotonic()
        self._share.renew(self._began)

    def hand_over(self) -> None:
        """What follows is the runtime's own work, until it is taken back or the step ends."""
        self._handed_over = time.monotonic()

    def take_back(self) -> None:
        """The action goes on, maybe in the same step."""
        if self._handed_over:
            self._excused += time.monotonic() - self._handed_over
            self._handed_over = 0.0

    def end(self) -> None:
        """A step ends, unless it has."""
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
        """Where the action waits at present, for people; empty if it has ended."""
        frame = self._coroutine.cr_frame
        return "" if frame is None else f"{_shown_file(frame.f_code)}:{frame.f_lineno}"


def place_of_thread(thread: threading.Thread, function: Callable[..., Any]) -> str:
    """Where a thread is at present, as a line of a function that it called; empty if it is not there any more."""
    code = getattr(inspect.unwrap(function), "__code__", None)
    frame = sys._current_frames().get(thread.ident or 0)
    while frame is not None and frame.f_code is not code:
        frame = frame.f_back
    return "" if frame is None else f"{_shown_file(frame.f_code)}:{frame.f_lineno}"


def _shown_file(code: CodeType) -> str:
    """The file of some code, for people: relative to the working directory, if it lies there."""
    path = Path(code.co_filename)
    with suppress(ValueError, OSError):
        path = path.relative_to(Path.cwd())
    return str(path)
