"""Processes for runs: some wait, having loaded all that a run needs, so that a run begins at once.

A process carries out one run, and ends with it. One that is asked to stop, and does not end, is killed with its
group.
"""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Final

from seoro.bridges import wire
from seoro.executor.frames import HEADER, Frame, Job, write_frame

MAX_FRAME: Final = 256 << 20  # [bytes]
END_TIMEOUT: Final = 10.0  # [s] that a process may last after it has told the end of its run


class Worker:
    """A process for one run. Made by `start_worker`."""

    def __init__(self, process: asyncio.subprocess.Process, control: int, reader: asyncio.StreamReader) -> None:
        self._process = process
        self._control = control
        self._reader = reader

    def begin(self, job: Job) -> None:
        """Give it its job."""
        with suppress(BrokenPipeError):  # it has died, which its other pipe tells
            self._write(Frame.JOB, wire.encode(job))

    def stop(self, reason: str) -> None:
        """Ask it to stop its run."""
        with suppress(OSError):
            self._write(Frame.STOP, reason.encode())

    def _write(self, kind: Frame, data: bytes) -> None:
        with os.fdopen(os.dup(self._control), "wb") as pipe:
            write_frame(pipe, kind, data)

    async def frames(self) -> AsyncIterator[tuple[Frame, bytes]]:
        """What it tells, to the end of its run or its own."""
        with suppress(asyncio.IncompleteReadError):
            while True:
                kind, length = HEADER.unpack(await self._reader.readexactly(HEADER.size))
                if length > MAX_FRAME:
                    return
                yield Frame(kind), await self._reader.readexactly(length)
                if kind == Frame.END:
                    return

    async def wait(self) -> int:
        """Wait for the end of the process, which is killed if it lasts; returns its exit status."""
        try:
            async with asyncio.timeout(END_TIMEOUT):
                return await self._process.wait()
        except TimeoutError:
            self.kill()
            return await self._process.wait()

    def kill(self) -> None:
        """Kill it with all processes of its group."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)

    def close(self) -> None:
        """Close the pipes; one that has no job ends then."""
        os.close(self._control)


async def start_worker() -> Worker:
    """Start a process that waits for a job."""
    control_read, control = os.pipe()
    data, data_write = os.pipe()
    command = [sys.executable, "-m", "seoro.executor.worker", str(control_read), str(data_write)]
    try:
        process = await asyncio.create_subprocess_exec(
            *command, stdin=subprocess.DEVNULL, pass_fds=(control_read, data_write), start_new_session=True
        )
    finally:
        os.close(control_read)
        os.close(data_write)
    loop, reader = asyncio.get_running_loop(), asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(data, "rb", buffering=0))
    return Worker(process, control, reader)


class Pool:
    """Processes that wait for jobs. Made by `open_pool`.

    Args:
        spare: How many wait.
    """

    def __init__(self, spare: int) -> None:
        self._spare = spare
        self._waiting: deque[Worker] = deque()
        self._filling = asyncio.Lock()

    async def fill(self, pause: float = 0.0) -> None:
        """Have as many as there should be, after a pause [s] if there are some: to start one takes a processor."""
        if self._waiting:
            await asyncio.sleep(pause)
        async with self._filling:
            while len(self._waiting) < self._spare:
                self._waiting.append(await start_worker())

    async def take(self) -> Worker:
        """One that nobody else has; another takes its place with the next `fill`."""
        return self._waiting.popleft() if self._waiting else await start_worker()

    async def close(self) -> None:
        """End those that wait."""
        while self._waiting:
            worker = self._waiting.popleft()
            worker.close()
            await worker.wait()


@asynccontextmanager
async def open_pool(spare: int) -> AsyncIterator[Pool]:
    """Have processes ready for as long as the block lasts."""
    pool = Pool(spare)
    try:
        await pool.fill()
        yield pool
    finally:
        await pool.close()
