"""State of a run that is not over, with the events that clients emit in it."""

from __future__ import annotations

import asyncio
import hashlib
import time
from collections.abc import Callable
from functools import partial
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo
from seoro.bridges.wire import Result, encode
from seoro.bridges.wire.refusal import RequestRefused
from seoro.concurrency.condition import Condition
from seoro.executor.process.frames import Frame
from seoro.executor.process.pool import Worker
from seoro.executor.runs.given_runs import GivenRuns
from seoro.executor.runs.tail import Pace, Watches

STOP_TIMEOUT: Final = 30.0  # [s] for the clean-up of a stopped run
KEPT: Final = 1000  # answered emissions that are kept, since clients repeat requests
MOST_PENDING: Final = 32 << 10  # [bytes] of unanswered emissions; the pipe of the process has room for more
OVER: Final = "the run is over: cannot emit events"


class ActiveRun:
    """A run that is not over.

    Args:
        info: Public state of the run.
        submission: Its submission.
        pace: Common pace of records for clients.

    Attributes:
        killed: Reason of a kill; empty without one.
        size: Size of its trace so far [bytes].
        output: Size of its other files at the last measurement [bytes].
        stop_reason: Reason of the stop request, or None.
        is_aborted: Whether it ends as an error, because it has exceeded a limit.
        is_left: Whether it is left for the next start of the executor.
        is_trace_known: Whether the file of the trace contains the sent lines only.
    """

    def __init__(self, info: RunInfo, submission: wire.Submission, pace: Pace) -> None:
        self.info = info
        self.submission = submission
        self.killed = ""
        self.size = 0
        self._trace = hashlib.sha256()  # hash so far
        self.is_trace_known = True
        self.changes = Condition()
        self.watches = Watches(pace)
        self.emissions = Emissions()
        self._given = GivenRuns()
        self._worker: Worker | None = None
        self.output = 0
        self.stop_reason: str | None = None
        self.is_aborted = False
        self._noted = time.monotonic()
        self._killing: asyncio.TimerHandle | None = None
        self.is_left = False

    @property
    def may_wait(self) -> bool:
        """Whether it waits for busy robots."""
        return self.submission.manifest.options.leasing.wait is not None

    @property
    def is_stopped(self) -> bool:
        """Whether it was asked to stop."""
        return self.stop_reason is not None

    def set(self, **changed: object) -> None:
        """Change fields of `info`."""
        self.info = self.info.model_copy(update=changed)
        self.watches.end_all()
        self.changes.notify_all()

    def grow(self, lines: bytes) -> None:
        """Append lines to the trace."""
        start = self.size
        self.size += len(lines)
        self._trace.update(lines)
        self.watches.grow(start, lines)
        self.changes.notify_all()

    @property
    def trace(self) -> str:
        """SHA-256 of its trace so far; empty if unknown."""
        return self._trace.hexdigest() if self.is_trace_known else ""

    def attach(self, worker: Worker) -> None:
        """Set the process of the run."""
        self._worker = worker
        if self.stop_reason is not None:
            self._stop(worker, self.stop_reason)

    def stop(self, reason: str) -> None:
        """Stop the run with clean-up; a process that does not end is killed."""
        if self.stop_reason is None:
            self.stop_reason = reason
            if self._worker is not None:
                self._stop(self._worker, reason)
            self.changes.notify_all()

    async def emit(self, request: wire.EmitEvent) -> wire.Emitted:
        """Emit an event in the run.

        Raises:
            RequestRefused: The run has not started, or rejects the event.
        """
        if self.submission.campaign is not None:
            raise RequestRefused(wire.NOT_EMITTED, "workers of campaigns receive no events")
        if self._worker is None:
            raise RequestRefused(wire.NOT_EMITTED, "the run has not started: cannot emit events yet")
        return await self.emissions.emit(request, partial(self._worker.send, Frame.EMIT))

    def give_runs(self, request: wire.PlannedRuns) -> None:
        """Give planned runs to the worker of a campaign.

        Raises:
            RequestRefused: The run is not such a worker, has no process, or has not read earlier runs.
        """
        if self.submission.campaign is None or self._worker is None:
            raise RequestRefused(Result.INCORRECT_STATE, "the run is not an active worker of a campaign")
        self._given.give(request, partial(self._worker.send, Frame.RUNS))

    def note_runs_read(self, part: int) -> None:
        """Record that the process has read a part of the given runs."""
        self._given.note_read(part)

    def abort(self, reason: str) -> None:
        """End the run as an error, unless it was stopped; a process that does not end is killed."""
        if self.stop_reason is None:
            self.is_aborted = True
            self.stop(reason)

    def halt(self, reason: str) -> None:
        """Stop the run without further motion of its robots."""
        self.stop(reason)
        self.halt_process(reason)

    def halt_process(self, reason: str) -> None:
        """Halt the process, if there is one; from any thread. `halt` has to follow."""
        if (worker := self._worker) is not None:
            worker.send(Frame.HALT, reason.encode())

    @property
    def has_process(self) -> bool:
        """Whether the run has a process."""
        return self._worker is not None

    def _stop(self, worker: Worker, reason: str) -> None:
        worker.send(Frame.ABORT if self.is_aborted else Frame.STOP, reason.encode())
        self._killing = asyncio.get_running_loop().call_later(STOP_TIMEOUT, worker.kill)

    def release(self) -> None:
        """Clear the process of the run, which has ended."""
        self._worker = None
        self.emissions.end()
        self.changes.notify_all()
        if self._killing is not None:
            self._killing.cancel()

    def note_client(self) -> None:
        """Record a request of the client without which the run is stopped."""
        self._noted = time.monotonic()

    @property
    def patience(self) -> float | None:
        """Time until the run is stopped without a request of its client [s]; None for no limit."""
        allowed = self.submission.stop_if_lost
        return None if allowed is None or self.is_stopped else self._noted + allowed - time.monotonic()


class Emissions:
    """Emissions in one run by their ids; a repeated request is one emission."""

    def __init__(self) -> None:
        self._found: dict[str, asyncio.Future[wire.Emitted]] = {}  # oldest first
        self._pending: dict[str, int] = {}  # sizes of unanswered emissions [bytes]

    async def emit(self, request: wire.EmitEvent, send: Callable[[bytes], object]) -> wire.Emitted:
        """Emit an event, and wait until it has occurred, at most for the time in the request.

        Args:
            request: The emission.
            send: Sends it to the process of the run.

        Raises:
            RequestRefused: The run rejects it, or too many emissions are pending.
        """
        found = self._found.get(request.emission)
        if found is None:
            found = self._begin(request, send)
        try:
            async with asyncio.timeout(request.wait):
                emitted = await asyncio.shield(found)
        except TimeoutError:
            return wire.Emitted(emission=request.emission)
        if emitted.refused:
            raise RequestRefused(wire.NOT_EMITTED, emitted.refused)
        return emitted

    def _begin(self, request: wire.EmitEvent, send: Callable[[bytes], object]) -> asyncio.Future[wire.Emitted]:
        data = encode(request)
        if sum(self._pending.values()) + len(data) > MOST_PENDING:
            raise RequestRefused(wire.UNAVAILABLE, "too many pending events in this run: try again later")
        answered = [each for each in self._found if each not in self._pending]
        for emission in answered[: max(0, len(self._found) + 1 - KEPT)]:
            del self._found[emission]
        found = self._found[request.emission] = asyncio.get_running_loop().create_future()
        self._pending[request.emission] = len(data)
        send(data)
        return found

    def conclude(self, emitted: wire.Emitted) -> None:
        """Store the outcome of an emission."""
        found = self._found.get(emitted.emission)
        self._pending.pop(emitted.emission, None)
        if found is not None and not found.done():
            found.set_result(emitted)

    def end(self) -> None:
        """Reject all pending emissions: the process of the run has ended."""
        for emission in list(self._pending):
            self.conclude(wire.Emitted(emission=emission, refused=OVER))
