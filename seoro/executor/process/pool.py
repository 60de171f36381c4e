"""Pool of processes for runs, which a fork server makes (`fork_server.py`), so that a run starts at once.

A process executes one run and ends with it. A process that does not end after a stop is killed with its group.
"""

from __future__ import annotations

import os
import threading
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from typing import Final

from seoro.concurrency.forks.using import Forked, Forks, open_forks
from seoro.executor.process.frames import HEADER, Frame, frame

MAX_FRAME: Final = 256 << 20  # [bytes]
READ_SIZE: Final = 1 << 16  # [bytes]
_MODULE: Final = "seoro.executor.process.fork_server"


class Worker:
    """Process of one run. Created by `Pool.acquire`.

    Args:
        forked: The process. Its pipe is for the job, and its reader for reports.
    """

    def __init__(self, forked: Forked) -> None:
        self.process = forked.process
        self._forked = forked
        self._controlling = threading.Lock()  # an emergency stop comes from a thread of its own
        self._is_closed = False

    def send(self, kind: Frame, data: bytes = b"") -> None:
        """Send a frame, from any thread; a dead process gets none, which the other pipe shows."""
        with self._controlling, suppress(OSError):
            if not self._is_closed:
                with os.fdopen(os.dup(self._forked.control), "wb") as pipe:
                    pipe.write(frame(kind, data))

    async def frames(self) -> AsyncIterator[tuple[Frame, bytes]]:
        """Yield the reports of the process, to the end of its run."""
        waiting = bytearray()
        while data := await self._forked.reader.read(READ_SIZE):
            waiting += data
            for kind, content in _frames_in(waiting):
                yield kind, content
                if kind == Frame.END:
                    return
            if len(waiting) > MAX_FRAME:
                return

    async def wait(self) -> int | None:
        """Wait for the end of the process, and kill it after a time; returns its exit status, or None."""
        return await self._forked.wait()

    def kill(self) -> None:
        """Kill the process with its group."""
        self._forked.kill()

    def close(self) -> None:
        """Close the pipe for its job."""
        with self._controlling:
            self._is_closed = True
            os.close(self._forked.control)


class Pool:
    """Source of processes for runs. Created by `open_pool`.

    Args:
        forks: Makes the processes.
        environment: Environment variables of the processes.
    """

    def __init__(self, forks: Forks, environment: Mapping[str, str]) -> None:
        self._forks = forks
        self._environment = environment

    async def acquire(self) -> Worker:
        """Return a new process.

        Raises:
            NoProcess: The fork server cannot make one.
        """
        return Worker(await self._forks.fork())

    @asynccontextmanager
    async def process(self, *, has_own_python: bool) -> AsyncIterator[Worker]:
        """Yield a new process, which the block closes.

        Args:
            has_own_python: Whether it shares no memory with other runs. Its Python starts for about a second.

        Raises:
            NoProcess: The fork server cannot make one.
        """
        if not has_own_python:
            yield await self.acquire()
            return
        async with open_forks(_MODULE, self._environment) as forks:
            yield Worker(await forks.fork())


@asynccontextmanager
async def open_pool(environment: Mapping[str, str]) -> AsyncIterator[Pool]:
    """Open a pool while the block lasts.

    Args:
        environment: Environment variables of the processes.
    """
    async with open_forks(_MODULE, environment) as forks:
        yield Pool(forks, environment)


def _frames_in(waiting: bytearray) -> list[tuple[Frame, bytes]]:
    """Remove whole frames from the received bytes; consecutive lines of the trace are joined."""
    found: list[tuple[Frame, bytes]] = []
    at = 0
    while at + HEADER.size <= len(waiting):
        kind, length = HEADER.unpack_from(waiting, at)
        if at + HEADER.size + length > len(waiting):
            break
        content = bytes(waiting[at + HEADER.size : at + HEADER.size + length])
        at += HEADER.size + length
        if found and kind == Frame.TRACE == found[-1][0]:
            found[-1] = Frame.TRACE, found[-1][1] + content
        else:
            found.append((Frame(kind), content))
    del waiting[:at]
    return found
