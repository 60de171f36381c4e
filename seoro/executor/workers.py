"""Processes for runs: one that has loaded all that a run needs makes them (`template.py`), so that a run begins at
once.

A process carries out one run, and ends with it. One that is asked to stop, and does not end, is killed with its
group.
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

from seoro.bridges import wire
from seoro.executor.frames import HEADER, TOLD, Frame, Job, Told, frame

MAX_FRAME: Final = 256 << 20  # [bytes]
READ_SIZE: Final = 1 << 16  # [bytes]
END_TIMEOUT: Final = 10.0  # [s] that a process may last after it has told the end of its run
_MODULE: Final = "seoro.executor.template"


class NoProcess(Exception):
    """No process can be had for a run."""


class Worker:
    """A process for one run. Made by `Pool.take`.

    Args:
        process: Its number.
        ended: Its exit status, once it has ended; None if nobody can tell.
        control: The pipe for its job, which it owns.
        reader: What it tells.
    """

    def __init__(
        self, process: int, ended: asyncio.Future[int | None], control: int, reader: asyncio.StreamReader
    ) -> None:
        self._process = process
        self._ended = ended
        self._control = control
        self._controlling = threading.Lock()  # an emergency stop comes from a thread of its own
        self._is_closed = False
        self._reader = reader

    @property
    def process(self) -> int:
        """The number of its process."""
        return self._process

    def begin(self, job: Job) -> None:
        """Give it its job."""
        with suppress(BrokenPipeError):  # it has died, which its other pipe tells
            self._write(Frame.JOB, wire.encode(job))

    def go(self) -> None:
        """Tell it that its run has its turn."""
        with suppress(OSError):
            self._write(Frame.GO, b"")

    def stop(self, reason: str) -> None:
        """Ask it to stop its run."""
        with suppress(OSError):
            self._write(Frame.STOP, reason.encode())

    def halt(self, reason: str) -> None:
        """Ask it to stop its run, and to do nothing after it."""
        with suppress(OSError):
            self._write(Frame.HALT, reason.encode())

    def give_up(self, reason: str) -> None:
        """Ask it to end its run as an error."""
        with suppress(OSError):
            self._write(Frame.GIVE_UP, reason.encode())

    def _write(self, kind: Frame, data: bytes) -> None:
        with self._controlling:
            if self._is_closed:
                return
            with os.fdopen(os.dup(self._control), "wb") as pipe:
                pipe.write(frame(kind, data))

    async def frames(self) -> AsyncIterator[tuple[Frame, bytes]]:
        """What it tells, to the end of its run or its own."""
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
        """Wait for the end of the process, which is killed if it lasts; returns its exit status, if known."""
        try:
            async with asyncio.timeout(END_TIMEOUT):
                return await asyncio.shield(self._ended)
        except TimeoutError:
            self.kill()
            return await self._ended

    def kill(self) -> None:
        """Kill it with all processes of its group."""
        with suppress(ProcessLookupError):
            os.killpg(self._process, signal.SIGKILL)

    def close(self) -> None:
        """Close the pipe for its job."""
        with self._controlling:
            self._is_closed = True
            os.close(self._control)


class Template:
    """The process that makes those of runs. Made by `start_template`.

    Args:
        process: It.
        requests: Where it is asked.
        told: What it tells.
    """

    def __init__(
        self, process: asyncio.subprocess.Process, requests: socket.socket, told: asyncio.StreamReader
    ) -> None:
        self._process = process
        self._requests = requests
        self._told = told
        self._ended: dict[int, asyncio.Future[int | None]] = {}
        self._started: asyncio.Future[int] | None = None
        self._listening = asyncio.create_task(self._listen())

    async def make(self, control: int, data: int) -> tuple[int, asyncio.Future[int | None]]:
        """Make a process with ends of a pipe and a socket; returns its number, and a future of its exit status.

        Raises:
            NoProcess: It has died.
        """
        self._started = asyncio.get_running_loop().create_future()
        try:
            if self._listening.done():
                raise BrokenPipeError
            socket.send_fds(self._requests, [b"."], [control, data])
            process = await self._started
        except OSError as error:
            raise NoProcess("the process that makes those of runs has died") from error
        finally:
            self._started = None
        return process, self._ended[process]

    async def _listen(self) -> None:
        with suppress(asyncio.IncompleteReadError):
            while True:
                what, process, code = TOLD.unpack(await self._told.readexactly(TOLD.size))
                if what == Told.ENDED:
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
        """End it; processes that it has made are left alone."""
        self._requests.close()
        try:
            async with asyncio.timeout(END_TIMEOUT):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
            await self._process.wait()
        await self._listening


async def start_template(environment: Mapping[str, str]) -> Template:
    """Start a process that makes others.

    Args:
        environment: Its environment variables.
    """
    ours, theirs = socket.socketpair()
    told, told_write = socket.socketpair()
    command = [sys.executable, "-m", _MODULE, str(theirs.fileno()), str(told_write.fileno())]
    try:
        process = await asyncio.create_subprocess_exec(
            *command,
            stdin=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(), told_write.fileno()),
            start_new_session=True,
            env=environment,
        )
    finally:
        theirs.close()
        told_write.close()
    return Template(process, ours, await _reader(told))


class Pool:
    """Where processes for runs come from. Made by `open_pool`.

    Args:
        template: Makes them.
        environment: Variables of one that is started in its place if it dies.
    """

    def __init__(self, template: Template, environment: Mapping[str, str]) -> None:
        self._template = template
        self._environment = environment
        self._taking = asyncio.Lock()

    async def take(self) -> Worker:
        """A process that nobody else has.

        Raises:
            NoProcess: None can be had.
        """
        async with self._taking:
            try:
                return await self._make()
            except NoProcess:
                await self._template.close()
                self._template = await start_template(self._environment)
                return await self._make()

    async def _make(self) -> Worker:
        control_read, control = os.pipe()
        data, data_write = socket.socketpair()
        try:
            process, ended = await self._template.make(control_read, data_write.fileno())
        except BaseException:
            os.close(control)
            data.close()
            raise
        finally:
            os.close(control_read)
            data_write.close()
        return Worker(process, ended, control, await _reader(data))

    async def close(self) -> None:
        """Make none any more."""
        await self._template.close()


@asynccontextmanager
async def open_pool(environment: Mapping[str, str]) -> AsyncIterator[Pool]:
    """Have processes for runs for as long as the block lasts.

    Args:
        environment: Variables that they have.
    """
    pool = Pool(await start_template(environment), environment)
    try:
        yield pool
    finally:
        await pool.close()


class _Told(asyncio.StreamReaderProtocol):
    """Reader of a connection that is closed at its end; the loop of uvloop would leave it half open."""

    def eof_received(self) -> bool:
        """There is nothing more."""
        super().eof_received()
        return False


async def _reader(end: socket.socket) -> asyncio.StreamReader:
    """Read a connection, which is owned by the reader.

    Connections are sockets: the loop of uvloop closes the descriptor of a pipe twice, which by then may be another
    one's, such as that of a file that another thread has opened.
    """
    loop, reader = asyncio.get_running_loop(), asyncio.StreamReader()
    await loop.create_unix_connection(lambda: _Told(reader), sock=end)
    return reader


def _frames_in(waiting: bytearray) -> list[tuple[Frame, bytes]]:
    """Take the whole frames off the beginning of what was read; lines of a trace that came together are one."""
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
