"""Pool of processes for runs, which a fork server makes (`fork_server.py`), so that a run starts at once.

A process executes one run and ends with it. A process that does not end after a stop is killed with its group.
"""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from typing import Final

from seoro.executor.process.frames import HEADER, REPORT, Frame, ProcessReport, frame

MAX_FRAME: Final = 256 << 20  # [bytes]
READ_SIZE: Final = 1 << 16  # [bytes]
END_TIMEOUT: Final = 10.0  # [s] for a process to end after the end of its run
_MODULE: Final = "seoro.executor.process.fork_server"


class NoProcess(Exception):
    """The fork server cannot make a process."""


class Worker:
    """Process of one run. Created by `Pool.acquire`.

    Args:
        process: Process id.
        ended: Exit status once the process has ended; None if unknown.
        control: Descriptor of the pipe for its job, which it owns.
        reader: Reader of its reports.
    """

    def __init__(
        self, process: int, ended: asyncio.Future[int | None], control: int, reader: asyncio.StreamReader
    ) -> None:
        self.process = process
        self._ended = ended
        self._control = control
        self._controlling = threading.Lock()  # an emergency stop comes from a thread of its own
        self._is_closed = False
        self._reader = reader

    def send(self, kind: Frame, data: bytes = b"") -> None:
        """Send a frame, from any thread; a dead process gets none, which the other pipe shows."""
        with self._controlling, suppress(OSError):
            if not self._is_closed:
                with os.fdopen(os.dup(self._control), "wb") as pipe:
                    pipe.write(frame(kind, data))

    async def frames(self) -> AsyncIterator[tuple[Frame, bytes]]:
        """Yield the reports of the process, to the end of its run."""
        waiting = bytearray()
        while data := await self._reader.read(READ_SIZE):
            waiting += data
            for kind, content in _frames_in(waiting):
                yield kind, content
                if kind == Frame.END:
                    return
            if len(waiting) > MAX_FRAME:
                return

    async def wait(self) -> int | None:
        """Wait for the end of the process, and kill it after a time; returns its exit status, or None."""
        try:
            async with asyncio.timeout(END_TIMEOUT):
                return await asyncio.shield(self._ended)
        except TimeoutError:
            self.kill()
            return await self._ended

    def kill(self) -> None:
        """Kill the process with its group."""
        with suppress(ProcessLookupError):
            os.killpg(self.process, signal.SIGKILL)

    def close(self) -> None:
        """Close the pipe for its job."""
        with self._controlling:
            self._is_closed = True
            os.close(self._control)


class ForkServer:
    """Executor's side of the fork server. Created by `start_fork_server`.

    Args:
        process: Process of the fork server.
        requests: Socket for requests.
        reports: Reader of its reports.
    """

    def __init__(
        self, process: asyncio.subprocess.Process, requests: socket.socket, reports: asyncio.StreamReader
    ) -> None:
        self._process = process
        self._requests = requests
        self._reports = reports
        self._ended: dict[int, asyncio.Future[int | None]] = {}
        self._started: asyncio.Future[int] | None = None
        self._listening = asyncio.create_task(self._listen())

    async def make(self, control: int, data: int) -> tuple[int, asyncio.Future[int | None]]:
        """Fork a process with a pipe and a socket; returns its process id, and a future of its exit status.

        Raises:
            NoProcess: The fork server has died.
        """
        self._started = asyncio.get_running_loop().create_future()
        try:
            if self._listening.done():
                raise BrokenPipeError
            socket.send_fds(self._requests, [b"."], [control, data])
            process = await self._started
        except OSError as error:
            raise NoProcess("the fork server for runs has died") from error
        finally:
            self._started = None
        return process, self._ended[process]

    async def _listen(self) -> None:
        with suppress(asyncio.IncompleteReadError):
            while True:
                what, process, code = REPORT.unpack(await self._reports.readexactly(REPORT.size))
                if what == ProcessReport.ENDED:
                    self._ended.pop(process).set_result(code)
                    continue
                self._ended[process] = asyncio.get_running_loop().create_future()
                if self._started is not None:
                    self._started.set_result(process)
        for ended in self._ended.values():
            ended.set_result(None)
        if self._started is not None:
            self._started.set_exception(BrokenPipeError())

    async def close(self) -> None:
        """End the fork server; its processes continue."""
        self._requests.close()
        try:
            async with asyncio.timeout(END_TIMEOUT):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
            await self._process.wait()
        await self._listening


async def start_fork_server(environment: Mapping[str, str]) -> ForkServer:
    """Start a fork server.

    Args:
        environment: Environment variables of its processes.
    """
    ours, theirs = socket.socketpair()
    reports, reports_write = socket.socketpair()
    command = [sys.executable, "-m", _MODULE, str(theirs.fileno()), str(reports_write.fileno())]
    try:
        process = await asyncio.create_subprocess_exec(
            *command,
            stdin=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(), reports_write.fileno()),
            start_new_session=True,
            env=environment,
        )
    finally:
        theirs.close()
        reports_write.close()
    return ForkServer(process, ours, await _reader(reports))


class Pool:
    """Source of processes for runs. Created by `open_pool`.

    Args:
        fork_server: Makes the processes.
        environment: Environment variables for a new fork server, if this one dies.
    """

    def __init__(self, fork_server: ForkServer, environment: Mapping[str, str]) -> None:
        self._fork_server = fork_server
        self._environment = environment
        self._taking = asyncio.Lock()

    async def acquire(self) -> Worker:
        """Return a new process.

        Raises:
            NoProcess: The fork server cannot make one.
        """
        async with self._taking:
            try:
                return await self._make()
            except NoProcess:
                await self._fork_server.close()
                self._fork_server = await start_fork_server(self._environment)
                return await self._make()

    async def _make(self) -> Worker:
        control_read, control = os.pipe()
        data, data_write = socket.socketpair()
        try:
            process, ended = await self._fork_server.make(control_read, data_write.fileno())
        except BaseException:
            os.close(control)
            data.close()
            raise
        finally:
            os.close(control_read)
            data_write.close()
        return Worker(process, ended, control, await _reader(data))

    async def close(self) -> None:
        """End the fork server."""
        await self._fork_server.close()


@asynccontextmanager
async def open_pool(environment: Mapping[str, str]) -> AsyncIterator[Pool]:
    """Open a pool while the block lasts.

    Args:
        environment: Environment variables of the processes.
    """
    pool = Pool(await start_fork_server(environment), environment)
    try:
        yield pool
    finally:
        await pool.close()


class _Told(asyncio.StreamReaderProtocol):
    """Reader that closes its connection at the end; uvloop would leave it half open."""

    def eof_received(self) -> bool:
        """Close the connection."""
        super().eof_received()
        return False


async def _reader(end: socket.socket) -> asyncio.StreamReader:
    """Return a reader that owns a connection.

    Connections are sockets: uvloop closes the descriptor of a pipe twice. By then another thread may have opened a
    file with the same number.
    """
    loop, reader = asyncio.get_running_loop(), asyncio.StreamReader()
    await loop.create_unix_connection(lambda: _Told(reader), sock=end)
    return reader


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
