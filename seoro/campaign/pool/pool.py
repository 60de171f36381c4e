"""The pool: slots of this machine, each with a worker process and, where runs need one, a simulator of its own."""

from __future__ import annotations

import asyncio
import math
import os
import platform
import signal
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import Final

from seoro.bundle.unpack import limit_of
from seoro.campaign.engine import Killed, NotBegun, WorkerDied
from seoro.campaign.pool.messages import FATAL, LOST, STOP, Start
from seoro.campaign.pool.simulators import Node, own_simulator, simulator_node
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.store.folder import CampaignFile
from seoro.concurrency.forks.using import Forked, Forks, NoProcess, open_forks
from seoro.errors import BackendError, UsageError

TEMPLATE: Final = "seoro.campaign.pool.template"
FROM_OUTSIDE: Final = {-signal.SIGKILL, -signal.SIGTERM, -signal.SIGINT, -signal.SIGHUP}  # ends of processes
AHEAD: Final = 8  # runs that a worker has in its pipe, which must not fill
MOST_FAILED: Final = 3  # starts of a simulator or of a worker, one after another
MARGIN: Final = 30.0  # [s] beyond the limit of wall time, for a run that does not end by itself


@asynccontextmanager
async def open_pool(campaign: CampaignFile, folder: Path, jobs: int) -> AsyncIterator[Pool]:
    """Open a pool while the block lasts.

    Args:
        campaign: Content of `campaign.json`.
        folder: Folder of the campaign.
        jobs: Number of simultaneous runs.

    Raises:
        BackendError: No process can be started.
    """
    async with open_forks(TEMPLATE, arguments=[str(folder)]) as forks:
        names = [f"{platform.node()}-{os.getpid():x}-{number}" for number in range(jobs)]
        slots = [_Slot(campaign, folder, forks, name) for name in names]
        try:
            yield Pool(slots)
        finally:
            await asyncio.gather(*(slot.close() for slot in slots))


class Pool:
    """Engine of this machine.

    Args:
        slots: Its slots.
    """

    def __init__(self, slots: Sequence[_Slot]) -> None:
        self._slots = slots
        self._free = list(slots)

    @property
    def slots(self) -> int:
        """Number of simultaneous chunks."""
        return len(self._slots)

    async def slots_changed(self) -> None:
        """Wait for ever, since the number of slots is fixed; see `Engine`."""
        await asyncio.get_running_loop().create_future()

    async def run(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        """Carry out a chunk; see `Engine`."""
        slot = self._free.pop()
        try:
            async for row in slot.run(runs):
                yield row
        finally:
            self._free.append(slot)

    def stop(self) -> None:
        """Stop the runs in progress; see `Engine`."""
        for slot in self._slots:
            slot.stop()


class _Slot:
    """A place for one run at a time; its worker and its simulator are replaced if they die."""

    def __init__(self, campaign: CampaignFile, folder: Path, forks: Forks, name: str) -> None:
        self._campaign = campaign
        self._folder = folder
        self._forks = forks
        self._name = name
        self._worker: Forked | None = None
        self._python = AsyncExitStack()  # of the worker, if it has a Python of its own
        self._stack = AsyncExitStack()  # of the simulator
        self._node: Node | None = None
        self._count = 0  # of workers
        self._is_stopped = False
        self._failed_starts = 0  # of the simulator, since it started last
        self._failed_forks = 0  # of a worker, since one started last
        self._limit = limit_of(campaign.manifest.options).seconds + MARGIN

    async def run(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        """Carry out a chunk."""
        if self._campaign.isolation == "worker":
            async for row in self._together(runs):
                yield row
            return
        for each in runs:  # each in a new process
            async for row in self._together([each]):
                yield row
            await self._end_worker()

    async def _together(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        """Carry out runs in one worker, or in another one with a new simulator after each error."""
        waiting = list(runs)
        while waiting:
            if self._is_stopped:
                raise NotBegun("the campaign is stopped")
            worker = self._worker = self._worker or await self._start_worker()
            for each in waiting[:AHEAD]:
                self._send(worker, each.to_line().encode())
            has_failed = False
            while waiting and not has_failed:
                row = await self._row(worker)
                if len(waiting) > AHEAD:
                    self._send(worker, waiting[AHEAD].to_line().encode())
                del waiting[0]
                has_failed = row.status is End.ERROR
                yield row
            if has_failed:  # maybe of the simulator
                await self._end_simulator()

    async def _row(self, worker: Forked) -> Row:
        """Wait for the next row.

        Raises:
            WorkerDied: The worker or its simulator has died, or the worker hangs.
            UsageError: Rows cannot be written.
        """
        try:
            async with asyncio.timeout(None if math.isinf(self._limit) else self._limit):
                line = await worker.reader.readline()
        except TimeoutError:
            await self._drop(worker)
            raise WorkerDied(f"the run did not end within {self._limit:g} s, and was killed") from None
        if line.startswith(FATAL):
            raise UsageError(f"cannot write results: {line[1:].decode(errors='replace').strip()}")
        if line == LOST:
            await self._drop(worker)
            raise await self._end_of_simulator()
        if not line.endswith(b"\n"):
            raise _death("the run", await self._drop(worker))
        return Row.from_line(line)

    async def _start_worker(self) -> Forked:
        """Start a worker, and first its simulator if it needs one.

        Raises:
            NotBegun: One of them did not start this time, but did before.
            BackendError: One of them did not start for the first time, or several times.
        """
        simulator = own_simulator(self._campaign.manifest.options.simulator)
        if simulator is not None and self._node is None and self._campaign.isolation != "process":
            self._node = await self._start_simulator(simulator)
        worker = await self._fork()
        self._count += 1
        start = Start(name=f"{self._name}-{self._count}")
        if self._node is not None:
            start = Start(name=start.name, endpoint=self._node.endpoint, simulator=self._node.process.pid)
        self._send(worker, start.model_dump_json().encode() + b"\n")
        if self._is_stopped:  # meanwhile
            self._send(worker, STOP)
        return worker

    async def _start_simulator(self, name: str) -> Node:
        """Start a simulator.

        Raises:
            NotBegun: It did not start this time, but did before.
            BackendError: It did not start for the first time, or several times.
        """
        try:
            node = await self._stack.enter_async_context(simulator_node(name))
        except BackendError as error:
            self._failed_starts += 1
            if not self._count or self._failed_starts == MOST_FAILED:
                raise
            raise NotBegun(str(error)) from error
        self._failed_starts = 0
        return node

    async def _fork(self) -> Forked:
        """Fork a worker; from a new Python for `process`.

        Raises:
            NotBegun: The fork server was killed; it will be started again.
            BackendError: It was not started for the first time, or several times.
        """
        forks = self._forks
        if self._campaign.isolation == "process":
            forks = await self._python.enter_async_context(open_forks(TEMPLATE, arguments=[str(self._folder)]))
        try:
            worker = await forks.fork()
        except NoProcess as error:
            await self._python.aclose()
            self._failed_forks += 1
            if not self._count or self._failed_forks == MOST_FAILED:
                raise BackendError(f"no worker can be started: {error}") from error
            raise NotBegun(str(error)) from error
        self._failed_forks = 0
        return worker

    def stop(self) -> None:
        """Stop the present run, and begin no others."""
        self._is_stopped = True
        if self._worker is not None:
            self._send(self._worker, STOP)

    async def close(self) -> None:
        """End the worker and the simulator."""
        await self._end_worker()
        await self._end_simulator()

    async def _end_worker(self) -> None:
        worker, self._worker = self._worker, None
        if worker is not None:
            os.close(worker.control)
            await worker.wait()
            await worker.drain()
            await self._python.aclose()

    async def _end_simulator(self) -> None:
        """End the simulator and the worker, which knows only this one."""
        if self._node is not None:
            await self._end_worker()
            self._node = None
            await self._stack.aclose()

    async def _end_of_simulator(self) -> WorkerDied:
        """Clean up after a simulator that has died; returns how it ended."""
        node = self._node
        assert node is not None, "it was that of the worker"
        await self._end_simulator()
        return _death("the simulator", node.process.returncode, node.errors[-1] if node.errors else "")

    async def _drop(self, worker: Forked) -> int | None:
        """Kill a worker that hangs or has died, with the programs that it has started; returns its exit status."""
        self._worker = None
        worker.kill()
        os.close(worker.control)
        status = await worker.ended
        await worker.drain()
        await self._python.aclose()
        return status

    def _send(self, worker: Forked, data: bytes) -> None:
        """Send to a worker; a dead one gets nothing, which its socket shows."""
        with suppress(OSError):
            while data:
                data = data[os.write(worker.control, data) :]


def _death(what: str, status: int | None, last: str = "") -> WorkerDied:
    """Describe the end of a process.

    Args:
        what: Owner of the process.
        status: Its exit status; None if it is unknown, since the fork server has died, too.
        last: Last line of its stderr; may be empty.
    """
    if status is None:
        return Killed("the worker died with its fork server")
    if status in FROM_OUTSIDE:
        return Killed(f"the process of {what} was killed by {signal.Signals(-status).name}")
    how = f"by {signal.Signals(-status).name}" if status < 0 else f"with status {status}"
    return WorkerDied(f"{what} ended its process {how}{last and f': {last}'}")
