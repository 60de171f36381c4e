"""The keeper of a process: a small process between a run and a program that it starts, which leaves nothing of it.

It is started by its path, `python -I -S keeper.py SIGNAL TIMEOUT COMMAND...`, with a socket as stdin, and imports
nothing of seoro. Its stdout and stderr are the program's. Over the socket it says

    started PID         the program runs
    failed ERRNO        it cannot be started; the keeper ends
    exited CODE         it has ended; negative for a signal
    left COUNT          so many processes could not be ended

and ends when nothing of the program is left, also of what that has started and left behind: orphans become
children of the keeper (`PR_SET_CHILD_SUBREAPER`, Linux). Told `stop`, it sends SIGNAL to all of them, also to what
is left behind later, and after TIMEOUT seconds SIGKILL. Told `kill`, it sends SIGKILL at once. When the socket
ends without either, the run has died; it does as for `stop`, in a hurry.
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
HURRY = 1.0  # [s] that programs have to end when the run has died
PERSISTENCE = 2.0  # [s] for which processes are killed that do not go
LOOK_INTERVAL = 0.05  # [s]; then what was started meanwhile is ended, too
ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)  # of the keeper itself

_Process = tuple[int, str]  # its number, and the program that it is at the moment


class _Keeper:
    """Keeps one program.

    Args:
        control: The socket to the run.
        ending: The signal that ends the program.
        timeout: How long that may take [s].
    """

    def __init__(self, control: socket.socket, ending: int, timeout: float) -> None:
        self._control = control
        self._ending = ending
        self._timeout = timeout
        self._program = 0
        self._is_listening = True  # whether the socket has not ended
        self._asked: set[_Process] = set()  # what was sent the signal
        self._look_at = math.inf
        self._kill_at = math.inf
        self._give_up_at = math.inf

    def keep(self, command: list[str]) -> None:
        """Start the program, and return when nothing of it is left."""
        wake = _wake_on_signals()
        files = [(os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0)]
        ignored = [signal.SIGPIPE, signal.SIGXFSZ]  # by Python, which is no business of the program
        try:
            self._program = os.posix_spawnp(
                command[0], command, os.environ, file_actions=files, setsid=True, setsigmask=(), setsigdef=ignored
            )
        except OSError as error:
            self._say(f"failed {error.errno}")
            return
        self._say(f"started {self._program}")
        nothing = os.open(os.devnull, os.O_RDWR)
        for mine in (1, 2):  # so that they end when the program's do
            os.dup2(nothing, mine)
        while self._reap():
            self._wait(wake)
            now = time.monotonic()
            if now >= self._give_up_at:
                self._say(f"left {len(_descendants())}")
                return
            if now >= self._look_at:
                self._look_at = now + LOOK_INTERVAL
                self._end_all(now)

    def _end_all(self, now: float) -> None:
        """Kill what is left, or, as long as it has time, ask what was not asked yet.

        What a process that was asked starts in order to end is its own business, until it leaves that behind. So
        is what it was just starting when it was asked, which is not among the descendants of that moment. What
        has become another program since it was asked is asked again: a shell's child takes the signal for the
        shell until it is the program that it is to be.
        """
        if now >= self._kill_at:
            self._give_up_at = min(self._give_up_at, now + PERSISTENCE)
            _signal_all(_descendants(), signal.SIGKILL)
            return
        left = [process for process in _children().get(os.getpid(), ()) if process not in self._asked]
        self._asked.update(left)
        _signal_all(left, self._ending)

    def _reap(self) -> bool:
        """Take note of what has ended; returns whether anything is left."""
        while True:
            try:
                child, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                return False
            if child == 0:
                return True
            if child == self._program:
                self._say(f"exited {os.waitstatus_to_exitcode(status)}")

    def _wait(self, wake: int) -> None:
        """Wait for something to happen, or for the time at which something is due."""
        due = self._look_at - time.monotonic()
        listened: list[int] = [wake, self._control.fileno()] if self._is_listening else [wake]
        ready, _, _ = select.select(listened, [], [], None if math.isinf(due) else max(0.0, due))
        if wake in ready and any(number in ENDING for number in os.read(wake, 4096)):
            self._end(self._timeout)
        if self._control.fileno() in ready:
            heard = self._hear()
            self._is_listening = bool(heard)
            self._end(0.0 if b"kill" in heard else self._timeout if heard else min(self._timeout, HURRY))

    def _hear(self) -> bytes:
        try:
            return self._control.recv(64)
        except OSError:
            return b""

    def _end(self, timeout: float) -> None:
        """Ask everything to end, unless that has been done; what has a shorter time left keeps that."""
        now = time.monotonic()
        if math.isinf(self._kill_at):
            self._asked.update(_descendants())
            _signal_all(self._asked, self._ending)
        self._look_at = now
        self._kill_at = min(self._kill_at, now + timeout)

    def _say(self, message: str) -> None:
        with suppress(OSError):  # nobody listens any more
            self._control.sendall(f"{message}\n".encode())


def _wake_on_signals() -> int:
    """A file that can be read when a signal has come: a byte for each."""
    wake, written = os.pipe()
    os.set_blocking(wake, False)
    os.set_blocking(written, False)
    signal.set_wakeup_fd(written, warn_on_full_buffer=False)
    for number in (signal.SIGCHLD, *ENDING):
        signal.signal(number, lambda *_: None)
    signal.pthread_sigmask(
        signal.SIG_SETMASK, ()
    )  # what started the run may have blocked them, which is inherited
    return wake


def _signal_all(processes: Iterable[_Process], number: int) -> None:
    for process, _ in processes:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(process, number)


def _descendants() -> list[_Process]:
    """Children, their children and so on, as far as they are alive."""
    children = _children()
    found = [(os.getpid(), "")]
    for process, _ in found:  # it grows
        found.extend(children.get(process, ()))
    return found[1:]


def _children() -> dict[int, list[_Process]]:
    """The processes that are alive, by the processes whose children they are."""
    children: dict[int, list[_Process]] = {}
    for entry in os.listdir("/proc"):  # noqa: PTH208 - pathlib takes longer to load than all else
        if entry.isdecimal():
            with suppress(OSError):
                with open(f"/proc/{entry}/stat", encoding="utf-8", errors="replace") as file:  # noqa: PTH123
                    name, _, rest = file.read().rpartition(")")
                state, parent = rest.split()[:2]
                if state != "Z":
                    children.setdefault(int(parent), []).append((int(entry), name))
    return children


def main(arguments: Sequence[str]) -> None:
    """Keep a program, as the arguments say."""
    number, timeout, *command = arguments
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    with socket.socket(fileno=os.dup(0)) as control:
        _Keeper(control, int(number), float(timeout)).keep(command)


if __name__ == "__main__":
    main(sys.argv[1:])
