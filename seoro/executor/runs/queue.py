"""Queue of runs that are not over: starts them when a slot is free, and follows them to their end."""

from __future__ import annotations

import asyncio
import logging
import os
import sqlite3
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Final, TypeAlias

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo, State
from seoro.bridges.wire import decode, encode
from seoro.concurrency.background import background
from seoro.concurrency.condition import Condition
from seoro.executor.job import make_job
from seoro.executor.limits import MEBIBYTE, Limits, Policy
from seoro.executor.process import frames
from seoro.executor.process.frames import Frame
from seoro.executor.process.pool import Pool, Worker
from seoro.executor.runs.active_run import ActiveRun
from seoro.executor.runs.ends import Ends
from seoro.executor.runs.enforcement import Reserve, append_trace, hold_to_time, hold_to_usage
from seoro.executor.runs.fair_queue import FairQueue
from seoro.executor.runs.outcome import outcome_of, storage_error, tidy
from seoro.executor.runs.run_slots import RunSlots
from seoro.executor.runs.shifts import PERIOD, ask_to_give_way
from seoro.executor.runs.tail import Pace
from seoro.executor.runs.usage import TraceFile
from seoro.executor.storage.store import Finished, Store

HAS_ROBOTS: Final = "holds its robots, and waits for a free run slot"

NoteEnd: TypeAlias = Callable[[RunInfo, str], Awaitable[object]]
"""Called with the state of a finished run and the role of its client."""

log = logging.getLogger(__name__)


class Queue:
    """Runs of an executor that are not over.

    Args:
        store: Storage of runs.
        pool: Pool of processes.
        tasks: Task group in which runs are followed.
        jobs: Number of active runs at a time.
        policy: Limits of clients.
        note_end: Called before the end of a run is stored.
        can_sandbox: Whether runs can be sandboxed.

    Attributes:
        ends: Ends of its runs.
        reserve: Room on the disk for traces.
    """

    def __init__(
        self,
        store: Store,
        pool: Pool,
        tasks: TaskGroup,
        jobs: int,
        policy: Policy,
        note_end: NoteEnd,
        *,
        can_sandbox: bool = False,
    ) -> None:
        self._store = store
        self._pool = pool
        self._tasks = tasks
        self._policy = policy
        self._note_end = note_end
        self._can_sandbox = can_sandbox
        self._live: dict[str, ActiveRun] = {}
        self._waiting = FairQueue()
        self._pace = Pace()
        self._changes = Condition()
        self.ends = Ends(store, self._changes, lambda run: self._live.pop(run, None))
        self.reserve = Reserve(store.blobs, self._live.values, self._limits)
        self._slots = RunSlots(jobs, policy, self._changes)
        self._is_closing = False
        self._held_back = ""

    def get(self, run: str) -> ActiveRun | None:
        """Return a run that is not over, or whose end is not stored yet; else None."""
        return self._live.get(run)

    @property
    def running(self) -> int:
        """Number of active runs."""
        return self._slots.taken

    @property
    def waiting(self) -> int:
        """Number of runs that wait for a slot or for robots."""
        return len(self._waiting) + len(self._slots.lent)

    def waiting_of(self, submitter: str) -> int:
        """Return the number of waiting runs of a client."""
        waiting = (*(self._live[run] for run in self._waiting), *self._slots.lent)
        return sum(live.info.by == submitter for live in waiting)

    def with_place(self, info: RunInfo) -> RunInfo:
        """Return the current state of a run, with its place in the queue."""
        live = self._live.get(info.run)
        info = info if live is None else live.info
        if info.run not in self._waiting:
            return info
        return info.model_copy(update={"place": self._waiting.places[info.run]})

    def forget(self, run: str) -> None:
        """Remove a finished run whose end is not stored yet."""
        self._live.pop(run, None)
        self.ends.forget(run)

    def add(self, info: RunInfo, submission: wire.Submission) -> None:
        """Add a run to the queue."""
        self._live[info.run] = ActiveRun(info, submission, self._pace)
        self._waiting.add(info.run, info.priority, info.by)
        self._changes.notify_all()

    async def work(self) -> None:
        """Start runs when slots are free; runs as long as the executor."""
        while True:
            run = self._waiting.take(await self._changes.wait_for(self._next))
            self._slots.acquire(self._live[run])
            self._tasks.start_soon(self._execute, self._live[run])

    def _next(self) -> str | None:
        """Return the run to start now, or None."""
        if self._is_closing or self._held_back:
            return None
        return self._waiting.first(lambda run: self._slots.is_free_for(self._live[run]))

    def _limits(self, live: ActiveRun) -> Limits:
        return self._policy.of(live.submission.role)

    async def stop(self, run: str, reason: str) -> None:
        """Stop a run; a waiting run is over at once."""
        live = self._live[run]
        if run in self._waiting:
            self._waiting.discard(run)
            await self._finish(live, State.CANCELLED, reason, b"")
        else:
            live.stop(reason)

    def hold_back(self, reason: str) -> None:
        """Start no runs for a reason, which clients of waiting runs see; an empty one allows starts again."""
        before, self._held_back = self._held_back, reason
        for run in self._waiting.places:
            live = self._live[run]
            if live.info.waits in ("", before):
                live.set(waits=reason)
        self._changes.notify_all()

    def halt_running(self, reason: str) -> None:
        """Request all active runs to stop without further motion of robots."""
        for live in self._active:
            live.halt(reason)

    def halt_processes(self, reason: str) -> tuple[str, ...]:
        """Halt the processes of all active runs, and start no others; returns the runs. From any thread.

        Then the event loop calls `hold_back` and `halt_running`.
        """
        self._held_back = reason
        live = dict(self._live)
        for each in live.values():
            each.halt_process(reason)
        return tuple(run for run in live if run not in self._waiting)

    @property
    def _active(self) -> list[ActiveRun]:
        return [live for run, live in self._live.items() if run not in self._waiting]

    async def stop_lonely(self) -> None:
        """Stop runs that lost their client, if submitted so; runs as long as the executor."""
        while True:
            for run, live in list(self._live.items()):
                if run in self._live and live.patience is not None and live.patience <= 0.0:
                    await self.stop(run, f"lost its client for {live.submission.stop_if_lost:g} s")
            left = [live.patience for live in self._live.values() if live.patience is not None]
            with anyio.move_on_after(max(min(left), 0.0) if left else None):
                await self._changes.wait()

    async def shift_workers(self) -> None:
        """Ask workers of campaigns to give way to waiting runs; runs as long as the executor."""
        while True:
            await self._changes.wait_for(lambda: len(self._waiting) > 0)
            waiting = [self._live[run] for run in self._waiting]
            ask_to_give_way(self._active, [live for live in waiting if self._slots.may_have_any(live)])
            await asyncio.sleep(PERIOD)

    async def close(self, reason: str) -> int:
        """Stop all active runs, and wait for their clean-up.

        Waiting runs, also for robots, are left for the next start.

        Returns:
            Number of stopped runs.
        """
        self._is_closing = True
        for live in self._slots.lent:
            live.is_left = not live.is_stopped
        running = self._active
        for live in running:
            live.stop(reason)
        for live in running:
            await live.changes.wait_for(lambda live=live: _has_ended(live))  # type: ignore[misc]
        await self.ends.retry()
        return len(running)

    async def _execute(self, live: ActiveRun) -> None:
        """Execute a run to its end."""
        try:
            await self._store.start(live.info.run)
            live.set(state=State.RUNNING, started=time.time())
            campaign = live.submission.campaign
            has_own_python = campaign is not None and campaign.has_own_python
            async with self._pool.process(has_own_python=has_own_python) as worker:
                try:
                    await self._execute_in(live, worker)
                except BaseException:
                    worker.kill()
                    raise
                finally:
                    live.release()
                    worker.close()
                    await worker.wait()
        except OSError as error:  # a full disk
            await self._finish(live, State.ERROR, storage_error(error), b"")
        except Exception as error:
            log.exception("fault in the run %s", live.info.run)
            await self._finish(live, State.ERROR, f"fault in the executor: {type(error).__name__}: {error}", b"")
        finally:
            self._slots.release(live)

    async def _execute_in(self, live: ActiveRun, worker: Worker) -> None:
        """Execute a run in a process; its end is reported before the process ends."""
        folder, limits = self._store.folder(live.info.run), self._limits(live)
        submission = live.submission
        job = make_job(
            submission.manifest, folder, limits, can_sandbox=self._can_sandbox, campaign=submission.campaign
        )
        worker.send(Frame.JOB, encode(job))
        live.attach(worker)
        async with background() as duties:
            duties.start_soon(hold_to_time, live, limits)
            duties.start_soon(hold_to_usage, live, worker, limits, folder)
            end = await self._follow(live, worker, duties)
        code = 0 if end else await worker.wait()
        if not end:
            worker.kill()  # programs that it has started, too
        if is_culprit := self.reserve.release(live.info.run):
            live.is_trace_known = False
        await asyncio.to_thread(tidy, folder, limits, is_culprit=is_culprit)
        await asyncio.to_thread(folder.sync)
        if live.is_left and code == frames.NOT_BEGUN:
            return
        state, reason = outcome_of(end, code, live)
        await self._finish(live, state, reason if end else live.killed or reason, end)

    async def _follow(self, live: ActiveRun, worker: Worker, duties: TaskGroup) -> bytes:
        """Store the trace that the process of a run sends; returns the packed end, or nothing.

        Raises:
            OSError: The trace could not be written; the run was stopped, and has cleaned up.
        """
        end, failed = b"", None
        limit = self._limits(live).trace
        assert limit is not None, "set by the default limits"
        with self._store.folder(live.info.run).trace.open("ab", buffering=0) as file:
            if os.fstat(file.fileno()).st_size:
                live.is_trace_known = False
            trace = TraceFile(file, limit * MEBIBYTE, self.reserve.of(live))
            async for kind, data in worker.frames():
                match kind:
                    case Frame.TRACE if failed is None:
                        try:
                            append_trace(live, trace, self.reserve, data)
                        except OSError as error:
                            failed = error
                            live.is_trace_known = False
                            live.stop(storage_error(error))
                    case Frame.BEGIN:
                        live.set(announcement=data.decode())
                        await self._store.announce(live.info.run, live.info.announcement)
                    case Frame.WAITS:
                        await self._lend_slot(live, data.decode())
                    case Frame.READY:
                        duties.start_soon(self._resume, live, worker)
                    case Frame.EMITTED:
                        live.emissions.conclude(decode(wire.Emitted, data))
                    case Frame.RUNS_TAKEN:
                        live.note_runs_read(int(data))
                    case Frame.END:
                        end = data
                    case Frame.TRACE | Frame.DRY_RUN_RESULT:  # not stored
                        pass
                    case Frame.JOB | Frame.STOP | Frame.GO | Frame.HALT | Frame.ABORT | Frame.EMIT | Frame.RUNS:
                        pass  # sent by the executor
        if failed is not None:
            raise failed
        return end

    async def _lend_slot(self, live: ActiveRun, for_whom: str) -> None:
        """Release the slot of a run that waits for robots."""
        if self._slots.lend(live):
            with suppress(sqlite3.Error):  # full disk: the run is lost if the executor dies now
                await self._store.wait(live.info.run)
        live.set(state=State.QUEUED, started=None, waits=for_whom)

    async def _resume(self, live: ActiveRun, worker: Worker) -> None:
        """Start a run that holds its robots, once it has a slot."""
        if not self._slots.is_free_again_for(live):
            live.set(waits=HAS_ROBOTS)
        await self._slots.acquire_again(live)
        try:
            await self._store.start(live.info.run)
        except sqlite3.Error as error:  # full disk: the stored state would be that of a run that has not begun
            live.stop(f"the executor cannot store the run: {error}")
            return
        live.set(state=State.RUNNING, started=time.time(), waits="")
        worker.send(Frame.GO)

    async def _finish(self, live: ActiveRun, state: State, reason: str, end: bytes) -> None:
        finished = Finished(state, reason, end, time.time(), live.trace)
        outcome = {"state": state, "reason": reason, "trace": live.trace}
        await self._note_end(live.info.model_copy(update=outcome), live.submission.role)
        await self.ends.store(live.info.run, finished)
        live.set(**outcome, ended=finished.ended)
        self._changes.notify_all()


def _has_ended(live: ActiveRun) -> bool:
    return live.info.state.is_final or (live.is_left and not live.has_process)
