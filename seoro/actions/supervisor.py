"""Supervisor process between a run and a program that it starts; it ends all processes of the program.

The run starts it by path, `python -I -S supervisor.py SIGNAL TIMEOUT COMMAND...`, with a socket as stdin. It
imports nothing of seoro. Its stdout and stderr are those of the program. It sends these messages over the socket:

- `started PID`: the program runs.
- `failed ERRNO`: the program cannot be started; the supervisor ends.
- `exited CODE`: the program has ended; negative for a signal.
- `left COUNT`: number of processes that could not be ended.

It ends when no process of the program is left, including orphans: they become children of the supervisor
(`PR_SET_CHILD_SUBREAPER`, Linux). On `stop`, it sends SIGNAL to all of them, also to later orphans, and SIGKILL
after TIMEOUT seconds. On `kill`, it sends SIGKILL at once. If the socket closes without either, the run has died:
it acts as on `stop`, with a short timeout.
"""

from __future__ import annotations

import ctypes
import math
import os
import select
import signal
import socket
import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress

PR_SET_CHILD_SUBREAPER = 36  # linux/prctl.h
ORPHAN_TIMEOUT = 1.0  # [s] that programs have to end when the run has died
PERSISTENCE = 2.0  # [s] for repeating SIGKILL
LOOK_INTERVAL = 0.05  # [s] between searches for new processes
ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)  # signals that end the supervisor itself

_Process = tuple[int, str]  # its number, and the name of its present program


class _Supervisor:
    """Supervises one program.

    Args:
        control: The socket to the run.
        ending: Signal that ends the program.
        timeout: Time until SIGKILL [s].
    """

    def __init__(self, control: socket.socket, ending: int, timeout: float) -> None:
        self._control = control
        self._ending = ending
        self._timeout = timeout
        self._program = 0
        self._is_listening = True  # until the socket has closed
        self._asked: set[_Process] = set()  # processes that were sent the signal
        self._look_at = math.inf
        self._kill_at = math.inf
        self._give_up_at = math.inf

    def run(self, command: list[str]) -> None:
        """Start the program, and return when none of its processes is left."""
        wake = _wake_on_signals()
        files = [(os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0)]
        ignored = [signal.SIGPIPE, signal.SIGXFSZ]  # by Python; the program gets the defaults
        try:
            self._program = os.posix_spawnp(
                command[0], command, os.environ, file_actions=files, setsid=True, setsigmask=(), setsigdef=ignored
            )
        except OSError as error:
            self._send(f"failed {error.errno}")
            return
        self._send(f"started {self._program}")
        nothing = os.open(os.devnull, os.O_RDWR)
        for mine in (1, 2):  # so that they close with the program's
            os.dup2(nothing, mine)
        while self._reap():
            self._wait(wake)
            now = time.monotonic()
            if now >= self._give_up_at:
                self._send(f"left {len(_descendants())}")
                return
            if now >= self._look_at:
                self._look_at = now + LOOK_INTERVAL
                self._end_all(now)

    def _end_all(self, now: float) -> None:
        """Kill the remaining processes, or send the signal to new orphans while the timeout lasts.

        A process that received the signal may start others in order to end; these are left alone until they become
        orphans. The same holds for processes that it was just starting. A process that has become another program
        since the signal receives it again: the child of a shell takes the signal for the shell until it has become
        its program.
        """
        if now >= self._kill_at:
            self._give_up_at = min(self._give_up_at, now + PERSISTENCE)
            _signal_all(_descendants(), signal.SIGKILL)
            return
        left = [process for process in _children().get(os.getpid(), ()) if process not in self._asked]
        self._asked.update(left)
        _signal_all(left, self._ending)

    def _reap(self) -> bool:
        """Reap ended processes; return whether any process is left."""
        while True:
            try:
                child, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                return False
            if child == 0:
                return True
            if child == self._program:
                self._send(f"exited {os.waitstatus_to_exitcode(status)}")

    def _wait(self, wake: int) -> None:
        """Wait for an event, or for the time of the next search."""
        due = self._look_at - time.monotonic()
        sources: list[int] = [wake, self._control.fileno()] if self._is_listening else [wake]
        ready, _, _ = select.select(sources, [], [], None if math.isinf(due) else max(0.0, due))
        if wake in ready and any(number in ENDING for number in os.read(wake, 4096)):
            self._end(self._timeout)
        if self._control.fileno() in ready:
            request = self._receive()
            self._is_listening = bool(request)
            default = self._timeout if request else min(self._timeout, ORPHAN_TIMEOUT)
            self._end(0.0 if b"kill" in request else default)

    def _receive(self) -> bytes:
        try:
            return self._control.recv(64)
        except OSError:
            return b""

    def _end(self, timeout: float) -> None:
        """Send the signal to all processes, unless done before. An earlier deadline stays."""
        now = time.monotonic()
        if math.isinf(self._kill_at):
            self._asked.update(_descendants())
            _signal_all(self._asked, self._ending)
        self._look_at = now
        self._kill_at = min(self._kill_at, now + timeout)

    def _send(self, message: str) -> None:
        with suppress(OSError):  # the run has died
            self._control.sendall(f"{message}\n".encode())


def _wake_on_signals() -> int:
    """Return a file descriptor that receives a byte per signal."""
    wake, written = os.pipe()
    os.set_blocking(wake, False)
    os.set_blocking(written, False)
    signal.set_wakeup_fd(written, warn_on_full_buffer=False)
    for number in (signal.SIGCHLD, *ENDING):
        signal.signal(number, lambda *_: None)
    signal.pthread_sigmask(
        signal.SIG_SETMASK, ()
    )  # the parent of the run may have blocked them, and children inherit that
    return wake


def _signal_all(processes: Iterable[_Process], number: int) -> None:
    for process, _ in processes:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(process, number)


def _descendants() -> list[_Process]:
    """Return all live descendants of this process."""
    children = _children()
    found = [(os.getpid(), "")]
    for process, _ in found:  # it grows
        found.extend(children.get(process, ()))
    return found[1:]


def _children() -> dict[int, list[_Process]]:
    """Return live processes by their parents."""
    children: dict[int, list[_Process]] = {}
    for entry in os.listdir("/proc"):  # noqa: PTH208 - loading pathlib would dominate the start
        if entry.isdecimal():
            with suppress(OSError):
                with open(f"/proc/{entry}/stat", encoding="utf-8", errors="replace") as file:  # noqa: PTH123
                    name, _, rest = file.read().rpartition(")")
                state, parent = rest.split()[:2]
                if state != "Z":
                    children.setdefault(int(parent), []).append((int(entry), name))
    return children


def main(arguments: Sequence[str]) -> None:
    """Run the supervisor with command-line arguments."""
    number, timeout, *command = arguments
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    with socket.socket(fileno=os.dup(0)) as control:
        _Supervisor(control, int(number), float(timeout)).run(command)


if __name__ == "__main__":
    main(sys.argv[1:])
