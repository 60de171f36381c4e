"""Processes that scenarios start: what all actions that run a program have in common.

A program runs in a session of its own under a keeper (`keeper.py`), which sees to it that nothing of it is left
when the run ends, or dies. Its output goes into the trace line by line, and is searched as it comes.
"""

from __future__ import annotations

import asyncio
import codecs
import errno
import os
import shlex
import signal
import socket
import subprocess
import sys
from collections import deque
from collections.abc import AsyncGenerator, Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import anyio
from anyio.abc import ByteReceiveStream, Process

from seoro.errors import ActionFailed
from seoro.runtime.context import ActionContext, Occasion

END_AFTER_OUTPUT = 1.0  # [s] that the end of a program may come after that of its output
LAST_WORDS = 0.2  # [s] that the last lines of a program that has ended may take to arrive
LAST_LINES = 5  # shown when a program fails
MAX_LINE = 4_096  # [characters]; what is longer is more than one line
MAX_KEPT = 1_000_000  # [characters] of output that can still be searched when it is over
MAX_LOGGED = 10_000  # lines of one program that go into the trace
CHUNK = 65_536  # [bytes] read at a time
RUNNING_PROGRAMS = ("run_process", "ros_run", "ros_launch")  # the actions whose labels are names of processes
KEEPER = Path(__file__).with_name("keeper.py")


@dataclass(frozen=True)
class Ending:
    """How a program is made to end.

    Args:
        number: The signal that it, and all that it has started, is sent.
        timeout: How long it may take then [s], before it is killed.
    """

    number: int = signal.SIGTERM
    timeout: float = 10.0


class RunningProcess:
    """A program that has been started.

    Args:
        name: What people call it.
        ctx: Of the action that starts it.
        is_awaited: Whether that waits for its end.
    """

    def __init__(self, name: str, ctx: ActionContext, *, is_awaited: bool) -> None:
        self.name = name
        self._ctx = ctx
        self._is_awaited = is_awaited
        self._to_log = MAX_LOGGED
        self._lines: deque[str] = deque()
        self._kept = 0  # characters in `_lines`
        self._searches: dict[asyncio.Future[str | None], Sequence[str]] = {}
        self.pid = 0  # once it has begun
        self.failure = 0  # `errno` of why it could not be started
        self.code: int | None = None  # its exit status, once it has ended; negative for a signal
        self.is_stopping = False  # whether its end is our doing
        self.began = anyio.Event()  # or has failed to
        self.exited = anyio.Event()
        self.gone = anyio.Event()  # with all that it has started
        self.when_gone: Callable[[], None] = lambda: None
        self.is_silent = anyio.Event()  # all output has come

    # -------------------------------------------------------- its output

    def take(self, lines: Sequence[str]) -> None:
        """Lines have come."""
        self._log(lines)
        for line in lines:
            self._lines.append(line)
            self._kept += len(line)
            while self._kept > MAX_KEPT:
                self._kept -= len(self._lines.popleft())
            for search, values in self._searches.items():
                if not search.done() and _has_any(line, values):
                    search.set_result(line)

    def _log(self, lines: Sequence[str]) -> None:
        if not self._to_log:
            return
        self._ctx.relay(lines[: self._to_log])
        self._to_log = max(0, self._to_log - len(lines))
        if not self._to_log:
            self._ctx.relay([f"`{self.name}` has written {MAX_LOGGED:,} lines; the rest is not logged"], "warning")

    def exit(self, code: int) -> None:
        """The program has ended, with this status."""
        self.code = code
        if code and not self._is_awaited and not self.is_stopping:
            self._ctx.relay([f"`{self.name}` {self.how_it_ended}"], "warning")
        self.exited.set()

    def end_output(self) -> None:
        """No more will come."""
        self.is_silent.set()
        for search in self._searches:
            if not search.done():
                search.set_result(None)

    async def find(self, values: Sequence[str], *, from_start: bool) -> str | None:
        """Wait for a line that has any of some texts in it; None if the output ends without one.

        Args:
            values: The texts.
            from_start: Whether to look at what has come before, too.
        """
        if from_start:
            for line in self._lines:
                if _has_any(line, values):
                    return line
        if self.is_silent.is_set():
            return None
        search: asyncio.Future[str | None] = asyncio.get_running_loop().create_future()
        self._searches[search] = values
        try:
            return await search
        finally:
            del self._searches[search]

    @property
    def last_lines(self) -> str:
        """The end of its output, for messages."""
        shown = [line for line in self._lines if line.strip()][-LAST_LINES:]
        return "".join(f"\n  {line}" for line in shown)

    async def end_of_output(self) -> str:
        """Why there is no more output, in a few words; its end is told a moment after that of its output."""
        with anyio.move_on_after(END_AFTER_OUTPUT):
            await self.exited.wait()
        return self.how_it_ended if self.exited.is_set() else "closed its output"

    @property
    def how_it_ended(self) -> str:
        """Its end, in a few words."""
        if self.code is not None and self.code < 0:
            with suppress(ValueError):
                return f"was killed by {signal.Signals(-self.code).name}"
        return f"ended with exit status {self.code}"


def _has_any(line: str, values: Iterable[str]) -> bool:
    return any(value in line for value in values)


# ---------------------------------------------------------------- for actions


class Processes:
    """The labelled processes of a run, by their labels."""

    def __init__(self) -> None:
        self._started: dict[str, dict[str, RunningProcess]] = {}
        self.start = Occasion()

    def begin(self, label: str, source: str) -> None:
        """An invocation with a label is going to start one: that of the time before is not meant any more."""
        self._started.get(label, {}).pop(source, None)

    def add(self, label: str, source: str, process: RunningProcess) -> None:
        """A process was started by an invocation with a label."""
        self._started.setdefault(label, {})[source] = process
        self.start.happen()

    def find(self, label: str) -> RunningProcess | None:
        """The process that was started last under a label; None if none was.

        Raises:
            ActionFailed: Several invocations of this label have started one.
        """
        found = self._started.get(label, {})
        if len(found) > 1:
            raise ActionFailed(f"several processes are called `{label}`: those of {', '.join(found)}")
        return next(iter(found.values()), None)


async def run_program(ctx: ActionContext, command: Sequence[str], ending: Ending, *, wait: bool) -> None:
    """Run a program; it is gone at the end of the run at the latest, with all that it has started.

    Args:
        ctx: Of the action.
        command: The program and its arguments.
        ending: How it is made to end.
        wait: Whether to wait for its end, and not only until it runs.

    Raises:
        ActionFailed: It cannot be started, or ends with a status other than 0.
    """
    ctx.extend_grace(ending.timeout)
    process = RunningProcess(ctx.label or Path(command[0]).name, ctx, is_awaited=wait)
    if ctx.label is not None:
        ctx.shared(Processes).begin(ctx.label, ctx.source)
    kept = await ctx.keep(_running(process, command, ending), ending.timeout)
    process.when_gone = kept.release
    if process.gone.is_set():
        kept.release()
    if process.failure:
        raise ActionFailed(_failure(command[0], process.failure))
    if ctx.label is not None:
        ctx.shared(Processes).add(ctx.label, ctx.source, process)
    if not wait:
        return
    try:
        await process.exited.wait()
        with anyio.move_on_after(LAST_WORDS):  # what it has started may go on, and hold its output open
            await process.is_silent.wait()
            await process.gone.wait()
            await kept.close()
    except asyncio.CancelledError:
        await kept.close()
        raise
    if process.code != 0:
        raise ActionFailed(f"`{process.name}` {process.how_it_ended}{process.last_lines}")


def split_command(command: str) -> Sequence[str]:
    """The words of a command, by the rules of a shell's quotes; nothing else in it has a meaning.

    Raises:
        ActionFailed: There is none, or a quote is not closed.
    """
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise ActionFailed(f"the command `{command}` cannot be split into words: {error}") from error
    if not words or not words[0] or "\0" in command:
        raise ActionFailed(f"`{command}` is no command")
    return words


def _failure(program: str, number: int) -> str:
    if number == errno.ENOENT:
        where = "no such file" if "/" in program else "it is in none of the folders of `PATH`"
        return f"there is no program `{program}`: {where}"
    return f"the program `{program}` cannot be started: {os.strerror(number)}"


# ---------------------------------------------------------------- under the keeper

_keepers: set[asyncio.StreamWriter] = set()  # of all programs of this process that may run


def kill_programs() -> None:
    """Kill all programs that this process keeps, with all that they have started, at once."""
    for keeper in _keepers:
        keeper.write(b"kill\n")


@asynccontextmanager
async def _running(
    process: RunningProcess, command: Sequence[str], ending: Ending
) -> AsyncGenerator[asyncio.StreamWriter]:
    """Start a program, and end it with the block; whether it could be started stands in it."""
    ours, theirs = socket.socketpair()
    with ExitStack() as stack, theirs:
        stack.callback(ours.close)
        with anyio.CancelScope(shield=True):  # of what is half begun, nobody knows that it has to end
            under = await anyio.open_process(
                [sys.executable, "-I", "-S", str(KEEPER), str(int(ending.number)), str(ending.timeout), *command],
                stdin=theirs.fileno(),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
            stack.pop_all()
            said, tell = await asyncio.open_connection(sock=ours)
    _keepers.add(tell)
    async with under, anyio.create_task_group() as group:
        group.start_soon(_follow, process, said)
        group.start_soon(_read_output, process, under)
        try:
            await process.began.wait()
            yield tell
            process.is_stopping = True
            tell.write(b"stop\n")
            await process.gone.wait()
        finally:
            with anyio.CancelScope(shield=True):
                _keepers.discard(tell)
                tell.close()  # then the keeper hurries, if there is anything left to do
                if await under.wait() != 0 and process.pid:  # it was killed, and leaves what it kept
                    with suppress(ProcessLookupError, PermissionError):
                        os.killpg(process.pid, signal.SIGKILL)
                with anyio.move_on_after(LAST_WORDS):
                    await process.is_silent.wait()
                group.cancel_scope.cancel()


async def _follow(process: RunningProcess, said: asyncio.StreamReader) -> None:
    """Take note of what the keeper says, until it has ended."""
    with suppress(OSError):
        async for line in said:
            word, number = line.split()
            match word:
                case b"started":
                    process.pid = int(number)
                    process.began.set()
                case b"failed":
                    process.failure = int(number)
                case b"exited":
                    process.exit(int(number))
                case b"left":
                    process.take([f"{int(number)} processes of `{process.name}` cannot be killed"])
    if process.code is None:  # it was not started, or its keeper was killed
        process.exit(-signal.SIGKILL)
    process.began.set()
    process.gone.set()
    process.when_gone()


async def _read_output(process: RunningProcess, under: Process) -> None:
    """Read both streams to their ends."""
    assert under.stdout is not None
    assert under.stderr is not None
    try:
        async with anyio.create_task_group() as group:
            group.start_soon(_read, under.stdout, process)
            group.start_soon(_read, under.stderr, process)
    finally:
        process.end_output()


async def _read(stream: ByteReceiveStream, process: RunningProcess) -> None:
    lines = _Lines()
    with suppress(anyio.EndOfStream, anyio.BrokenResourceError):
        while True:
            if found := list(lines.feed(await stream.receive(CHUNK))):
                process.take(found)
    if found := list(lines.feed(b"", is_end=True)):
        process.take(found)


@dataclass
class _Lines:
    """Makes lines of bytes."""

    rest: str = ""
    decoder: codecs.IncrementalDecoder = field(
        default_factory=lambda: codecs.getincrementaldecoder("utf-8")(errors="replace")
    )

    def feed(self, data: bytes, *, is_end: bool = False) -> Iterator[str]:
        """The lines that are complete with these bytes."""
        *whole, self.rest = (self.rest + self.decoder.decode(data, is_end)).split("\n")
        if self.rest and (is_end or len(self.rest) > MAX_LINE):
            whole.append(self.rest)
            self.rest = ""
        for line in whole:
            bare = line.rstrip("\r")
            yield from (bare[at : at + MAX_LINE] for at in range(0, max(1, len(bare)), MAX_LINE))
