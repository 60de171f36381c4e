"""Processes started by scenarios: common to all actions that run a program.

A program runs in a session of its own under a supervisor (`supervisor.py`), which ends all of its processes when
the run ends or dies. Its output is logged in the trace line by line, and searched as it arrives.
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
from collections.abc import AsyncGenerator, Callable, Iterable, Sequence
from contextlib import ExitStack, asynccontextmanager, suppress
from pathlib import Path

import anyio
from anyio.abc import ByteReceiveStream, Process

from seoro.errors import ActionFailed
from seoro.lang import frozen
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.actions.pending import Notifier

END_AFTER_OUTPUT = 1.0  # [s] by which the exit may follow the end of the output
LAST_OUTPUT = 0.2  # [s] for the last lines after the exit
LAST_LINES = 5  # shown when a program fails
MAX_LINE = 4_096  # [characters]; longer lines are split
MAX_KEPT = 1_000_000  # [characters] of past output that can be searched
MAX_LOGGED = 10_000  # lines per program in the trace
CHUNK = 65_536  # [bytes] read at a time
RUNNING_PROGRAMS = ("run_process", "ros_run", "ros_launch")  # actions whose labels name processes
SUPERVISOR = Path(__file__).with_name("supervisor.py")


class Ending(frozen.Value):
    """Signal and time limit for ending a program.

    Args:
        number: Signal sent to the program and to all processes that it started.
        timeout: Time until the remaining processes are killed [s].
    """

    number: int = signal.SIGTERM
    timeout: float = 10.0


class RunningProcess:
    """A started program.

    Args:
        name: Name in messages.
        ctx: Context of the action that starts it.
        is_awaited: Whether the action waits for its exit.
    """

    def __init__(self, name: str, ctx: ActionContext, *, is_awaited: bool) -> None:
        self.name = name
        self._ctx = ctx
        self._is_awaited = is_awaited
        self._to_log = MAX_LOGGED
        self._lines: deque[str] = deque()
        self._kept = 0  # characters in `_lines`
        self._searches: dict[asyncio.Future[str | None], Sequence[str]] = {}
        self.pid = 0  # once started
        self.failure = 0  # `errno` if it could not be started
        self.code: int | None = None  # exit status; negative for a signal
        self.is_stopping = False  # whether seoro ends it
        self.began = anyio.Event()  # or failed to start
        self.exited = anyio.Event()
        self.gone = anyio.Event()  # with all processes that it started
        self.on_gone: Callable[[], None] = lambda: None
        self.is_silent = anyio.Event()  # all output has been read

    # -------------------------------------------------------- its output

    def add_lines(self, lines: Sequence[str]) -> None:
        """Log lines, keep them, and complete searches."""
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
            self._ctx.relay(
                [f"`{self.name}` has written {MAX_LOGGED:,} lines; further lines are not logged"], "warning"
            )

    def exit(self, code: int) -> None:
        """Note the exit of the program."""
        self.code = code
        if code and not self._is_awaited and not self.is_stopping:
            self._ctx.relay([f"`{self.name}` {self.how_it_ended}"], "warning")
        self.exited.set()

    def end_output(self) -> None:
        """Note the end of the output."""
        self.is_silent.set()
        for search in self._searches:
            if not search.done():
                search.set_result(None)

    async def find(self, values: Sequence[str], *, from_start: bool) -> str | None:
        """Wait for a line that contains any of the texts; return None if the output ends without one.

        Args:
            values: The texts.
            from_start: Whether to search earlier output too.
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
        """The last lines of the output, for messages."""
        shown = [line for line in self._lines if line.strip()][-LAST_LINES:]
        return "".join(f"\n  {line}" for line in shown)

    async def end_of_output(self) -> str:
        """Describe the end of the output. The exit is reported a moment later than the end of the output."""
        with anyio.move_on_after(END_AFTER_OUTPUT):
            await self.exited.wait()
        return self.how_it_ended if self.exited.is_set() else "closed its output"

    @property
    def how_it_ended(self) -> str:
        """Description of the exit."""
        if self.code is not None and self.code < 0:
            with suppress(ValueError):
                return f"was killed by {signal.Signals(-self.code).name}"
        return f"ended with exit status {self.code}"


def _has_any(line: str, values: Iterable[str]) -> bool:
    return any(value in line for value in values)


# ---------------------------------------------------------------- for actions


class Processes:
    """Labelled processes of a run."""

    def __init__(self) -> None:
        self._started: dict[str, dict[str, RunningProcess]] = {}
        self.start = Notifier()

    def begin(self, label: str, source: str) -> None:
        """Forget the earlier process of an invocation that starts again."""
        self._started.get(label, {}).pop(source, None)

    def add(self, label: str, source: str, process: RunningProcess) -> None:
        """Add a process started by a labelled invocation."""
        self._started.setdefault(label, {})[source] = process
        self.start.notify()

    def find(self, label: str) -> RunningProcess | None:
        """Return the last process started under a label; None if none was started.

        Raises:
            ActionFailed: Several invocations with this label have started one.
        """
        found = self._started.get(label, {})
        if len(found) > 1:
            raise ActionFailed(f"ambiguous process `{label}`: started at {', '.join(found)}; use different labels")
        return next(iter(found.values()), None)


async def run_program(ctx: ActionContext, command: Sequence[str], ending: Ending, *, wait: bool) -> None:
    """Run a program. The end of the run ends it and all processes that it started.

    Args:
        ctx: Context of the action.
        command: The program and its arguments.
        ending: Signal and time limit for ending it.
        wait: Whether to wait for its exit, not only for its start.

    Raises:
        ActionFailed: It could not be started, or its exit status is not 0.
    """
    ctx.extend_grace(ending.timeout)
    process = RunningProcess(ctx.label or Path(command[0]).name, ctx, is_awaited=wait)
    if ctx.label is not None:
        ctx.shared(Processes).begin(ctx.label, ctx.source)
    kept = await ctx.keep(_running(process, command, ending), ending.timeout)
    process.on_gone = kept.release
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
        with anyio.move_on_after(LAST_OUTPUT):  # child processes may go on and keep its output open
            await process.is_silent.wait()
            await process.gone.wait()
            await kept.close()
    except asyncio.CancelledError:
        await kept.close()
        raise
    if process.code != 0:
        raise ActionFailed(f"`{process.name}` {process.how_it_ended}{process.last_lines}")


def split_command(command: str) -> Sequence[str]:
    """Split a command into words by the quoting rules of a shell, without expansions.

    Raises:
        ActionFailed: The command is empty, or a quote is not closed.
    """
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise ActionFailed(f"cannot split the command `{command}` into words: {error}") from error
    if not words or not words[0] or "\0" in command:
        raise ActionFailed(f"invalid command `{command}`; expected a program and its arguments")
    return words


def _failure(program: str, number: int) -> str:
    if number == errno.ENOENT:
        where = "no such file" if "/" in program else "not found in the folders of `PATH`"
        return f"unknown program `{program}`: {where}"
    return f"cannot start the program `{program}`: {os.strerror(number)}"


# ---------------------------------------------------------------- supervisors

_supervisors: set[asyncio.StreamWriter] = set()  # of all programs of this process that may be running


def kill_programs() -> None:
    """Kill all programs started by this process, and their child processes, immediately."""
    for supervisor in _supervisors:
        supervisor.write(b"kill\n")


@asynccontextmanager
async def _running(
    process: RunningProcess, command: Sequence[str], ending: Ending
) -> AsyncGenerator[asyncio.StreamWriter]:
    """Start a program, and end it with the block; `process` notes whether it could be started."""
    ours, theirs = socket.socketpair()
    with ExitStack() as stack, theirs:
        stack.callback(ours.close)
        with anyio.CancelScope(shield=True):  # a half-started program could not be ended
            arguments = [str(int(ending.number)), str(ending.timeout), *command]
            under = await anyio.open_process(
                [sys.executable, "-I", "-S", str(SUPERVISOR), *arguments],
                stdin=theirs.fileno(),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
            stack.pop_all()
            reports, requests = await asyncio.open_connection(sock=ours)
    _supervisors.add(requests)
    async with under, anyio.create_task_group() as group:
        group.start_soon(_follow, process, reports)
        group.start_soon(_read_output, process, under)
        try:
            await process.began.wait()
            yield requests
            process.is_stopping = True
            requests.write(b"stop\n")
            await process.gone.wait()
        finally:
            with anyio.CancelScope(shield=True):
                _supervisors.discard(requests)
                requests.close()  # the supervisor then ends all remaining processes quickly
                if await under.wait() != 0 and process.pid:  # it was killed and left the program running
                    with suppress(ProcessLookupError, PermissionError):
                        os.killpg(process.pid, signal.SIGKILL)
                with anyio.move_on_after(LAST_OUTPUT):
                    await process.is_silent.wait()
                group.cancel_scope.cancel()


async def _follow(process: RunningProcess, reports: asyncio.StreamReader) -> None:
    """Handle the reports of the supervisor, until it has ended."""
    with suppress(OSError):
        async for line in reports:
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
                    process.add_lines([f"{int(number)} processes of `{process.name}` cannot be killed"])
    if process.code is None:  # it was not started, or its supervisor was killed
        process.exit(-signal.SIGKILL)
    process.began.set()
    process.gone.set()
    process.on_gone()


async def _read_output(process: RunningProcess, under: Process) -> None:
    """Read both output streams to their ends."""
    assert under.stdout is not None
    assert under.stderr is not None
    try:
        async with anyio.create_task_group() as group:
            group.start_soon(_read, under.stdout, process)
            group.start_soon(_read, under.stderr, process)
    finally:
        process.end_output()


async def _read(stream: ByteReceiveStream, process: RunningProcess) -> None:
    """Read lines of an output stream to its end."""
    decoder, rest, is_open = codecs.getincrementaldecoder("utf-8")(errors="replace"), "", True
    while is_open:
        try:
            data = await stream.receive(CHUNK)
        except (anyio.EndOfStream, anyio.BrokenResourceError):
            data, is_open = b"", False
        *whole, rest = (rest + decoder.decode(data, not is_open)).split("\n")
        if rest and (not is_open or len(rest) > MAX_LINE):
            whole.append(rest)
            rest = ""
        bare = (line.rstrip("\r") for line in whole)
        lines = [line[at : at + MAX_LINE] for line in bare for at in range(0, max(1, len(line)), MAX_LINE)]
        if lines:
            process.add_lines(lines)
