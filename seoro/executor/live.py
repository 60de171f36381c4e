"""A run that is not over, as its executor has it."""

from __future__ import annotations

import asyncio
import hashlib
import time
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo
from seoro.changes import Changes
from seoro.executor.watching import Pace, Watches
from seoro.executor.workers import Worker

STOP_TIMEOUT: Final = 30.0  # [s] that a run may take to clean up when it is stopped


class LiveRun:
    """A run that is not over.

    Args:
        info: What is known of it.
        submission: What it was submitted with.
        pace: Of what is sent to those who follow runs.
    """

    def __init__(self, info: RunInfo, submission: wire.Submission, pace: Pace) -> None:
        self.info = info
        self.submission = submission
        self.killed = ""  # why it was, if it was
        self.size = 0  # of its trace so far [bytes]
        self._trace = hashlib.sha256()  # of the same
        self._is_trace_known = True
        self.changes = Changes()  # of all of that
        self.watches = Watches(pace)  # of the same, at once
        self._worker: Worker | None = None
        self.output = 0  # of its other files [bytes], as far as that is known
        self._stop_reason: str | None = None
        self._is_given_up = False
        self._watched = time.monotonic()
        self._killing: asyncio.TimerHandle | None = None
        self._is_left = False

    @property
    def may_wait(self) -> bool:
        """Whether it waits for robots that others have."""
        return self.submission.manifest.options.leasing.wait is not None

    @property
    def is_stopped(self) -> bool:
        """Whether it was asked to stop."""
        return self._stop_reason is not None

    @property
    def is_given_up(self) -> bool:
        """Whether it ends as an error, because it has reached a limit."""
        return self._is_given_up

    @property
    def stop_reason(self) -> str | None:
        """Why it was asked to stop; None if it was not."""
        return self._stop_reason

    def set(self, **changed: object) -> None:
        """Something about it has changed."""
        self.info = self.info.model_copy(update=changed)
        self.watches.turn()
        self.changes.tell()

    def grow(self, lines: bytes) -> None:
        """Its trace has grown."""
        start = self.size
        self.size += len(lines)
        self._trace.update(lines)
        self.watches.grow(start, lines)
        self.changes.tell()

    def doubt_trace(self) -> None:
        """Its trace may have lines that it has not grown by."""
        self._is_trace_known = False

    @property
    def trace(self) -> str:
        """SHA-256 of its trace so far; empty if that is unknown."""
        return self._trace.hexdigest() if self._is_trace_known else ""

    def have(self, worker: Worker) -> None:
        """It has a process."""
        self._worker = worker
        if self._stop_reason is not None:
            self._stop(worker, self._stop_reason)

    def stop(self, reason: str) -> None:
        """Stop it, in order; a process that does not end is killed."""
        if self._stop_reason is None:
            self._stop_reason = reason
            if self._worker is not None:
                self._stop(self._worker, reason)
            self.changes.tell()

    def give_up(self, reason: str) -> None:
        """End it as an error, unless it was stopped; a process that does not end is killed."""
        if self._stop_reason is None:
            self._is_given_up = True
            self.stop(reason)

    def halt(self, reason: str) -> None:
        """Stop it, also what is done with its robots after it."""
        self.stop(reason)
        if self._worker is not None:
            self._worker.halt(reason)

    def halt_process(self, reason: str) -> None:
        """Tell its process to halt, if it has one; from any thread. `halt` has to follow."""
        if (worker := self._worker) is not None:
            worker.halt(reason)

    def leave(self) -> None:
        """When its process has ended without having begun it, it is left for the next start of the executor."""
        self._is_left = not self.is_stopped

    @property
    def is_left(self) -> bool:
        """Whether it is left for the next start of the executor."""
        return self._is_left

    @property
    def has_process(self) -> bool:
        """Whether there is something of it that may be stopped."""
        return self._worker is not None

    def _stop(self, worker: Worker, reason: str) -> None:
        if self._is_given_up:
            worker.give_up(reason)
        else:
            worker.stop(reason)
        self._killing = asyncio.get_running_loop().call_later(STOP_TIMEOUT, worker.kill)

    def release(self) -> None:
        """Its process has ended."""
        self._worker = None
        self.changes.tell()
        if self._killing is not None:
            self._killing.cancel()

    def note_watcher(self) -> None:
        """Whoever is to be there for it to go on has given a sign of life."""
        self._watched = time.monotonic()

    @property
    def patience(self) -> float | None:
        """How much longer it goes on without a sign of life [s]; None if it does so for ever, or is stopped."""
        allowed = self.submission.stop_if_lost
        return None if allowed is None or self.is_stopped else self._watched + allowed - time.monotonic()
