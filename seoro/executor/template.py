"""The process from which those of runs are made: `python -m seoro.executor.template REQUESTS TOLD`, the numbers of
two open sockets.

It loads all that runs need, once, and then forks for each run. So a run begins a few milliseconds after it was
asked for, in a process of its own in which no run was before it, and shares the memory of what was loaded with
all others. Nothing runs here, and there is one thread only, so that what is forked is whole.

A request is a byte with two descriptors: of the pipe for the job, and of the socket for reports about it. The
second socket reports which process was started, and how a process ended.
"""

from __future__ import annotations

import gc
import os
import select
import signal
import socket
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

from seoro.embed import check_file
from seoro.embed import run as run_scenario
from seoro.executor.frames import TOLD, Told
from seoro.executor.sandbox import visible_folders
from seoro.executor.worker import work
from seoro.lang.loader import read_file

DESCRIPTORS: Final = 2  # with a request
_WARM_UP: Final = """import osc.helpers
scenario warm_up:
    do serial:
        log("ready")
        wait elapsed(1s)
"""


def main(arguments: Sequence[str]) -> None:
    """Make processes, to the end of the executor."""
    number, told = map(int, arguments)
    for each in (number, told):
        os.set_inheritable(each, False)
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_IGN)  # those are for the executor
    _warm_up()
    assert threading.active_count() == 1, "locks of other threads would stay locked in what is forked"
    gc.collect()
    gc.freeze()  # or looking for garbage would copy what is shared
    pipes = None
    with socket.socket(fileno=number) as requests, suppress(BrokenPipeError):  # the executor has died
        pipes = _make_processes(requests, told)
    if pipes is not None:
        work(*pipes)


def _warm_up() -> None:
    """Run a scenario that does nothing, which loads what is loaded on demand, and find what sandboxes need."""
    visible_folders()
    path = Path("warm_up.osc")
    scenario = check_file(path, read=lambda other: _WARM_UP if other == path else read_file(other))
    run_scenario(scenario, clock="virtual", seed=0)


def _make_processes(requests: socket.socket, told: int) -> tuple[int, int] | None:
    """Fork when asked to, and tell of those that end; returns the pipes of its run in a process that was made, and
    None in this one, when the executor is gone.
    """
    woken, wake = socket.socketpair()
    with woken, wake:
        wake.setblocking(False)
        signal.set_wakeup_fd(wake.fileno())
        signal.signal(signal.SIGCHLD, lambda *_: None)
        while True:
            ready, _, _ = select.select([requests, woken], [], [])
            if woken in ready:
                woken.recv(4096)
                _tell_of_ended(told)
            if requests in ready:
                request, pipes, _, _ = socket.recv_fds(requests, 1, DESCRIPTORS)
                if not request:
                    signal.set_wakeup_fd(-1)  # which is closed
                    return None
                process = os.fork()
                with suppress(OSError):  # on both sides, so that neither is too early; it may have ended
                    os.setpgid(process, process)
                if process == 0:
                    signal.set_wakeup_fd(-1)
                    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                    os.close(told)
                    control, data = pipes
                    return control, data
                os.write(told, TOLD.pack(Told.STARTED, process, 0))
                for pipe in pipes:
                    os.close(pipe)


def _tell_of_ended(told: int) -> None:
    with suppress(ChildProcessError):  # there is none at all
        while (ended := os.waitpid(-1, os.WNOHANG))[0]:
            os.write(told, TOLD.pack(Told.ENDED, ended[0], os.waitstatus_to_exitcode(ended[1])))


if __name__ == "__main__":
    main(sys.argv[1:])
