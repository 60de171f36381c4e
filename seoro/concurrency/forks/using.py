"""The user's side of a fork server."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from functools import partial
from typing import Final, NamedTuple

from seoro.concurrency.forks.reports import REPORT, ProcessReport

END_TIMEOUT: Final = 10.0  # [s] time limit of a process to end
DRAIN_TIMEOUT: Final = 1.0  # [s] time limit of the output of an ended process to end
_BLOCK: Final = 1 << 16  # [bytes]


class NoProcess(Exception):
    """The fork server cannot make a process."""


class Forked(NamedTuple):
    """A forked process.

    Args:
        process: Process id.
        ended: Its exit status once it has ended; None if unknown.
        control: Descriptor of the pipe to it, which the receiver of this value owns.
        reader: Reader of its output.
    """

    process: int
    ended: asyncio.Future[int | None]
    control: int
    reader: asyncio.StreamReader

    async def wait(self) -> int | None:
        """Wait for its end, and kill it after a time; returns its exit status, or None."""
        try:
            async with asyncio.timeout(END_TIMEOUT):
                return await asyncio.shield(self.ended)
        except TimeoutError:
            self.kill()
            return await self.ended

    async def drain(self) -> None:
        """Wait until its output ends, which closes the connection; its children may keep it open for a time."""
        with suppress(TimeoutError):
            async with asyncio.timeout(DRAIN_TIMEOUT):
                while await self.reader.read(_BLOCK):
                    pass

    def kill(self) -> None:
        """Kill the process with its group."""
        with suppress(ProcessLookupError):
            os.killpg(self.process, signal.SIGKILL)


class _ForkServer:
    """User's side of a fork server.

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

    async def fork(self) -> Forked:
        """Fork a process; one at a time.

        Raises:
            NoProcess: The fork server has died.
        """
        control_read, control = os.pipe()
        data, data_write = socket.socketpair()
        try:
            process, ended = await self._make(control_read, data_write.fileno())
        except BaseException:
            os.close(control)
            data.close()
            raise
        finally:
            os.close(control_read)
            data_write.close()
        return Forked(process, ended, control, await socket_reader(data))

    async def _make(self, control: int, data: int) -> tuple[int, asyncio.Future[int | None]]:
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
        try:
            await self._receive()
        finally:  # also if the event loop ends, which cancels all tasks
            for ended in self._ended.values():
                _end(ended, None)
            if self._started is not None and not self._started.done():
                self._started.set_exception(BrokenPipeError())

    async def _receive(self) -> None:
        """Receive reports until the fork server ends."""
        with suppress(asyncio.IncompleteReadError, OSError):
            while True:
                what, process, code = REPORT.unpack(await self._reports.readexactly(REPORT.size))
                if what == ProcessReport.ENDED:
                    _end(self._ended.pop(process), code)
                    continue
                self._ended[process] = asyncio.get_running_loop().create_future()
                if self._started is not None:
                    self._started.set_result(process)

    async def close(self) -> None:
        """End it; its processes continue."""
        self._requests.close()
        try:
            async with asyncio.timeout(END_TIMEOUT):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
            await self._process.wait()
        await asyncio.wait([self._listening])


def _end(ended: asyncio.Future[int | None], code: int | None) -> None:
    """Set the exit status of a process, unless the task that waits for it was cancelled."""
    if not ended.done():
        ended.set_result(code)


class Forks:
    """Source of forked processes: a fork server, and another one if it dies. Created by `open_forks`.

    Args:
        start: Starts a fork server.
        server: The first one.
    """

    def __init__(self, start: Callable[[], Awaitable[_ForkServer]], server: _ForkServer) -> None:
        self._start = start
        self._server = server
        self._taking = asyncio.Lock()

    async def fork(self) -> Forked:
        """Fork a process, with a pipe to it and a socket from it.

        Raises:
            NoProcess: The fork server has died, and so has its successor.
        """
        async with self._taking:
            try:
                return await self._server.fork()
            except NoProcess:
                await self._server.close()
                self._server = await self._start()
                return await self._server.fork()

    async def close(self) -> None:
        """End the fork server; its processes continue."""
        await self._server.close()


@asynccontextmanager
async def open_forks(
    module: str, environment: Mapping[str, str] | None = None, arguments: Sequence[str] = ()
) -> AsyncIterator[Forks]:
    """Run a fork server while the block lasts.

    Args:
        module: Its module, which gets the two descriptors of `serve_forks` as first arguments.
        environment: Environment variables of its processes; None for those of this process.
        arguments: Further arguments of the module.
    """
    start = partial(_start_fork_server, module, environment, arguments)
    forks = Forks(start, await start())
    try:
        yield forks
    finally:
        await forks.close()


async def _start_fork_server(
    module: str, environment: Mapping[str, str] | None, arguments: Sequence[str]
) -> _ForkServer:
    ours, theirs = socket.socketpair()
    reports, reports_write = socket.socketpair()
    command = [sys.executable, "-m", module, str(theirs.fileno()), str(reports_write.fileno()), *arguments]
    try:
        process = await asyncio.create_subprocess_exec(
            *command,
            stdin=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(), reports_write.fileno()),
            start_new_session=True,
            env=environment,
        )
        return _ForkServer(process, ours, await socket_reader(reports))
    except BaseException:  # also if it is cancelled
        ours.close()
        reports.close()
        raise
    finally:
        theirs.close()
        reports_write.close()


class _Told(asyncio.StreamReaderProtocol):
    """Reader that closes its connection at the end; uvloop would leave it half open."""

    def eof_received(self) -> bool:
        """Close the connection."""
        super().eof_received()
        return False


async def socket_reader(end: socket.socket) -> asyncio.StreamReader:
    """Return a reader that owns a connection.

    Connections are sockets: uvloop closes the descriptor of a pipe twice. By then another thread may have opened a
    file with the same number.
    """
    loop, reader = asyncio.get_running_loop(), asyncio.StreamReader()
    await loop.create_unix_connection(lambda: _Told(reader), sock=end)
    return reader
