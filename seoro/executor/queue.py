"""Runs that are not over: they wait for their turn, get a process, and are seen to until their end."""

from __future__ import annotations

import asyncio
import logging
import os
import shutil
import sqlite3
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Final, TypeAlias

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from seoro.background import background
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo, State
from seoro.changes import Changes
from seoro.embed.ends import Ended, InvalidEnd, unpack_end
from seoro.executor import frames
from seoro.executor.frames import Frame
from seoro.executor.holding import KEPT_OF_CULPRIT, Reserve, TraceKeeper, hold_to_time, hold_to_usage
from seoro.executor.jobs import make_job
from seoro.executor.limits import MEBIBYTE, Limits, Policy
from seoro.executor.live import STOP_TIMEOUT, LiveRun
from seoro.executor.order import Waiting
from seoro.executor.quota import TraceFile, cut
from seoro.executor.store import Finished, RunFolder, Store
from seoro.executor.turns import Turns
from seoro.executor.watching import Pace
from seoro.executor.workers import Pool, Worker

KEEP_PAUSE: Final = 5.0  # [s] until it is tried again to keep the end of a run
HAS_ROBOTS: Final = "the robots are held for it until it has its turn"
_KILLED: Final = f"it did not end within {STOP_TIMEOUT:g} s of being stopped, and was killed"

NoteEnd: TypeAlias = Callable[[RunInfo, str], Awaitable[object]]
"""Is told what has become of a run, and the role of its submitter."""

log = logging.getLogger(__name__)


class Queue:
    """The runs of an executor that are not over.

    Args:
        store: Keeps them.
        pool: Of processes.
        tasks: In which runs are seen to.
        jobs: How many go on at a time.
        policy: What their submitters may.
        note_end: Called before the end of a run is kept.
        can_sandbox: Whether runs can be sandboxed.
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
        self._live: dict[str, LiveRun] = {}
        self._waiting = Waiting()
        self._pace = Pace()
        self._ends: dict[str, Finished] = {}
        self._changes = Changes()
        self.reserve = Reserve(store.blobs, self._live.values, self._limits)
        self._turns = Turns(jobs, policy, self._changes)
        self._is_closing = False
        self._held_back = ""

    def get(self, run: str) -> LiveRun | None:
        """A run, if it is not over, or its end could not be kept."""
        return self._live.get(run)

    @property
    def running(self) -> int:
        """How many runs go on."""
        return self._turns.taken

    @property
    def waiting(self) -> int:
        """How many wait, for their turn or for robots."""
        return len(self._waiting) + len(self._turns.lent)

    def waiting_of(self, submitter: str) -> int:
        """How many of somebody's runs wait."""
        waiting = (*(self._live[run] for run in self._waiting), *self._turns.lent)
        return sum(live.info.by == submitter for live in waiting)

    def placed(self, info: RunInfo) -> RunInfo:
        """What is known of a run, with its place if it waits; of one that is not over, more than the store has."""
        live = self._live.get(info.run)
        info = info if live is None else live.info
        if info.run not in self._waiting:
            return info
        return info.model_copy(update={"place": self._waiting.places[info.run]})

    def forget(self, run: str) -> None:
        """A run that is over is removed; it is here only if its end could not be kept."""
        self._live.pop(run, None)
        self._ends.pop(run, None)

    def add(self, info: RunInfo, submission: wire.Submission) -> None:
        """A run is to be carried out."""
        self._live[info.run] = LiveRun(info, submission, self._pace)
        self._waiting.add(info.run, info.priority, info.by)
        self._changes.tell()

    async def work(self) -> None:
        """Start runs as there is room for them; runs as long as the executor."""
        while True:
            run = self._waiting.take(await self._changes.wait_for(self._next))
            self._turns.take(self._live[run])
            self._tasks.start_soon(self._carry, self._live[run])

    def _next(self) -> str | None:
        """The run to start now, if there is one."""
        if self._is_closing or self._held_back:
            return None
        return self._waiting.first(lambda run: self._turns.is_free_for(self._live[run]))

    def _limits(self, live: LiveRun) -> Limits:
        return self._policy.of(live.submission.role)

    async def stop(self, run: str, reason: str) -> None:
        """Stop a run; one that waits is over at once."""
        live = self._live[run]
        if run in self._waiting:
            self._waiting.discard(run)
            await self._finish(live, State.CANCELLED, reason, b"")
        else:
            live.stop(reason)

    def hold_back(self, reason: str) -> None:
        """Let no run begin for a reason, or let them begin again if there is none.

        Clients of the runs that wait are told why.
        """
        before, self._held_back = self._held_back, reason
        for run in self._waiting.places:
            live = self._live[run]
            if live.info.waits in ("", before):
                live.set(waits=reason)
        self._changes.tell()

    def stop_running(self, reason: str) -> tuple[str, ...]:
        """Stop all runs that go on, and return which; it is not waited for their ends."""
        for run in self._going_on:
            self._live[run].stop(reason)
        return self._going_on

    def halt_running(self, reason: str) -> tuple[str, ...]:
        """The same, and nothing is done with robots after them."""
        for run in self._going_on:
            self._live[run].halt(reason)
        return self._going_on

    def halt_processes(self, reason: str) -> tuple[str, ...]:
        """Tell the processes of all runs that go on to halt, and return the runs; let none begin. From any thread.

        The event loop follows up by `hold_back` and `halt_running`.
        """
        self._held_back = reason
        live = dict(self._live)
        for each in live.values():
            each.halt_process(reason)
        return tuple(run for run in live if run not in self._waiting)

    @property
    def _going_on(self) -> tuple[str, ...]:
        return tuple(run for run in self._live if run not in self._waiting)

    async def stop_lonely(self) -> None:
        """Stop runs whose watchers are gone, where that is asked for; runs as long as the executor."""
        while True:
            for run, live in list(self._live.items()):
                if run in self._live and live.patience is not None and live.patience <= 0.0:
                    await self.stop(run, f"its watcher was gone for {live.submission.stop_if_lost:g} s")
            left = [live.patience for live in self._live.values() if live.patience is not None]
            with anyio.move_on_after(max(min(left), 0.0) if left else None):
                await self._changes.wait()

    async def keep_ends(self) -> None:
        """Keep ends that could not be kept at once; runs as long as the executor."""
        while True:
            await self._changes.wait_for(lambda: self._ends)
            await asyncio.sleep(KEEP_PAUSE)
            await self._keep_again()

    async def _keep_again(self) -> None:
        for run, finished in list(self._ends.items()):
            if await self._keep(run, finished):
                self._ends.pop(run, None)

    async def close(self, reason: str) -> int:
        """Stop what runs, for a reason, and wait for its clean-up.

        What waits, also for robots, is left for the next start.

        Returns:
            How many runs were stopped.
        """
        self._is_closing = True
        for live in self._turns.lent:
            live.leave()
        running = [self._live[run] for run in self.stop_running(reason)]
        for live in running:
            await live.changes.wait_for(lambda live=live: _is_done_with(live))  # type: ignore[misc]
        await self._keep_again()
        return len(running)

    async def _carry(self, live: LiveRun) -> None:
        """Carry a run out to its end."""
        try:
            await self._store.start(live.info.run)
            live.set(state=State.RUNNING, started=time.time())
            worker = await self._pool.take()
            try:
                await self._carry_by(live, worker)
            except BaseException:
                worker.kill()
                raise
            finally:
                live.release()
                worker.close()
                await worker.wait()
        except OSError as error:  # a full disk
            await self._finish(live, State.ERROR, _unkept(error), b"")
        except Exception as error:
            log.exception("fault in the run %s", live.info.run)
            await self._finish(live, State.ERROR, f"fault in the executor: {type(error).__name__}: {error}", b"")
        finally:
            self._turns.end(live)

    async def _carry_by(self, live: LiveRun, worker: Worker) -> None:
        """Have a process carry a run out; whoever waits for its end need not wait for that of the process."""
        folder, limits = self._store.folder(live.info.run), self._limits(live)
        worker.begin(make_job(live.submission.manifest, folder, limits, can_sandbox=self._can_sandbox))
        live.have(worker)
        async with background() as duties:
            duties.start_soon(hold_to_time, live, limits)
            duties.start_soon(hold_to_usage, live, worker, limits, folder)
            end = await self._follow(live, worker, duties)
        code = 0 if end else await worker.wait()
        if not end:
            worker.kill()  # what it has started, and did not end
        if is_culprit := self.reserve.release(live.info.run):
            live.doubt_trace()
        await asyncio.to_thread(_tidy, folder, limits, is_culprit=is_culprit)
        await asyncio.to_thread(folder.sync)
        if live.is_left and code == frames.NOT_BEGUN:
            return
        state, reason = _outcome(end, code, live)
        await self._finish(live, state, reason if end else live.killed or reason, end)

    async def _follow(self, live: LiveRun, worker: Worker, duties: TaskGroup) -> bytes:
        """Keep what the process of a run tells; returns the end of the run, empty if it told none.

        Raises:
            OSError: The trace could not be written; the run was stopped, and has cleaned up.
        """
        end, failed = b"", None
        limit = self._limits(live).trace
        assert limit is not None, "the limits of an executor have it"
        with self._store.folder(live.info.run).trace.open("ab", buffering=0) as file:
            if os.fstat(file.fileno()).st_size:
                live.doubt_trace()
            trace = TraceFile(file, limit * MEBIBYTE, self.reserve.of(live))
            keeper = TraceKeeper(live, trace, limit, self.reserve)
            async for kind, data in worker.frames():
                match kind:
                    case Frame.TRACE if failed is None:
                        try:
                            keeper.keep(data)
                        except OSError as error:
                            failed = error
                            live.doubt_trace()
                            live.stop(_unkept(error))
                    case Frame.BEGIN:
                        live.set(announcement=data.decode())
                        await self._store.announce(live.info.run, live.info.announcement)
                    case Frame.WAITS:
                        await self._lend_turn(live, data.decode())
                    case Frame.READY:
                        duties.start_soon(self._give_turn, live, worker)
                    case Frame.END:
                        end = data
                    case Frame.TRACE | Frame.TRIED:  # which is not kept
                        pass
                    case Frame.JOB | Frame.STOP | Frame.GO | Frame.HALT | Frame.GIVE_UP:  # what goes the other way
                        pass
        if failed is not None:
            raise failed
        return end

    async def _lend_turn(self, live: LiveRun, for_whom: str) -> None:
        """A run waits for robots, and others may go on meanwhile."""
        if self._turns.lend(live):
            with suppress(sqlite3.Error):  # a full disk: it is lost, then, if the executor dies
                await self._store.wait(live.info.run)
        live.set(state=State.QUEUED, started=None, waits=for_whom)

    async def _give_turn(self, live: LiveRun, worker: Worker) -> None:
        """A run has its robots, and goes on when it has a turn, too."""
        if not self._turns.is_free_again_for(live):
            live.set(waits=HAS_ROBOTS)
        await self._turns.take_again(live)
        try:
            await self._store.start(live.info.run)
        except sqlite3.Error as error:  # a full disk: nobody must take it for one that has not begun
            live.stop(f"the executor cannot keep the run: {error}")
            return
        live.set(state=State.RUNNING, started=time.time(), waits="")
        worker.go()

    async def _finish(self, live: LiveRun, state: State, reason: str, end: bytes) -> None:
        finished = Finished(state, reason, end, time.time(), live.trace)
        said = {"state": state, "reason": reason, "trace": live.trace}
        await self._note_end(live.info.model_copy(update=said), live.submission.role)
        if not await self._keep(live.info.run, finished):
            log.warning("cannot keep the end of the run %s yet", live.info.run)
            self._ends[live.info.run] = finished
        live.set(**said, ended=finished.ended)
        self._changes.tell()

    async def _keep(self, run: str, finished: Finished) -> bool:
        """Keep the end of a run, which else is known here only, and taken for lost by the next start."""
        try:
            await self._store.finish(run, finished)
        except sqlite3.Error:  # a full disk
            return False
        self._live.pop(run, None)
        return True


def _is_done_with(live: LiveRun) -> bool:
    return live.info.state.is_final or (live.is_left and not live.has_process)


def _unkept(error: OSError) -> str:
    return f"the executor cannot keep the run: {error.strerror or error}"


def _tidy(folder: RunFolder, limits: Limits, *, is_culprit: bool) -> None:
    """Remove what a run has left that is of no use, and cut what is too much."""
    shutil.rmtree(folder.home, ignore_errors=True)
    if is_culprit:
        cut(folder.trace, KEPT_OF_CULPRIT)
    if limits.log is not None:
        cut(folder.log, limits.log * MEBIBYTE)
    with suppress(OSError):
        if folder.log.lstat().st_size == 0:
            folder.log.unlink()


def _outcome(end: bytes, code: int | None, live: LiveRun) -> tuple[State, str]:
    """What has become of a run whose process has ended."""
    if not end:
        match code:
            case frames.NOT_BEGUN if live.stop_reason is not None:
                return State.ERROR if live.is_given_up else State.CANCELLED, live.stop_reason
            case None:
                how = "ended"
            case _ if code < 0:
                how = f"was killed by signal {-code}"
            case _:
                how = f"ended with status {code}"
        if live.is_given_up:
            return State.ERROR, f"{live.stop_reason}; {_KILLED}"
        return State.ERROR, _KILLED if live.is_stopped else f"its process {how} before the end of the run"
    try:
        found = unpack_end(end)
    except InvalidEnd as error:
        return State.ERROR, str(error)
    if isinstance(found, Ended):
        return State(found.verdict.status.value), found.verdict.reason
    if found.backend:
        return State.ERROR, found.backend
    reason = found.misuse.message if found.misuse is not None else found.diagnostics[0].message
    return State.INVALID, reason
