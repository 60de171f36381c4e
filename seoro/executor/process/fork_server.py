"""Fork server for runs: `python -m seoro.executor.process.fork_server REQUESTS REPORTS`, two socket descriptors.

It loads all modules for runs once, and forks a process for each run. So a run starts within milliseconds, in a
fresh process that shares the memory of loaded modules with the others. The fork server runs no scenarios and has a
single thread, so that forked processes are consistent.

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
from seoro.executor.process.frames import REPORT, ProcessReport
from seoro.executor.process.worker import work
from seoro.executor.sandbox.command import visible_folders
from seoro.lang.loader import read_file

DESCRIPTORS: Final = 2  # with a request
_WARM_UP: Final = """import osc.helpers
scenario warm_up:
    do serial:
        log("ready")
        wait elapsed(1s)
"""


def main(arguments: Sequence[str]) -> None:
    """Fork processes until the executor ends."""
    number, reports = map(int, arguments)
    for each in (number, reports):
        os.set_inheritable(each, False)
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_IGN)  # meant for the executor
    _warm_up()
    assert threading.active_count() == 1, "locks of other threads would stay locked in forked processes"
    gc.collect()
    gc.freeze()  # else garbage collection would copy shared pages
    pipes = None
    with socket.socket(fileno=number) as requests, suppress(BrokenPipeError):  # the executor has died
        pipes = _make_processes(requests, reports)
    if pipes is not None:
        work(*pipes)


def _warm_up() -> None:
    """Run a small scenario to load modules that are imported on demand, and find the folders for sandboxes."""
    visible_folders()
    path = Path("warm_up.osc")
    scenario = check_file(path, read=lambda other: _WARM_UP if other == path else read_file(other))
    run_scenario(scenario, clock="virtual", seed=0)


def _make_processes(requests: socket.socket, reports: int) -> tuple[int, int] | None:
    """Fork on request, and report ended processes.

    Returns:
        The pipes of the run, in a forked process; None in the fork server, when the executor has ended.
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
                _report_ended(reports)
            if requests in ready:
                request, pipes, _, _ = socket.recv_fds(requests, 1, DESCRIPTORS)
                if not request:
                    signal.set_wakeup_fd(-1)  # it is closed next
                    return None
                process = os.fork()
                with suppress(OSError):  # on both sides, so that neither is too early; it may have ended
                    os.setpgid(process, process)
                if process == 0:
                    signal.set_wakeup_fd(-1)
                    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                    os.close(reports)
                    control, data = pipes
                    return control, data
                os.write(reports, REPORT.pack(ProcessReport.STARTED, process, 0))
                for pipe in pipes:
                    os.close(pipe)


def _report_ended(reports: int) -> None:
    with suppress(ChildProcessError):  # no children
        while (ended := os.waitpid(-1, os.WNOHANG))[0]:
            os.write(reports, REPORT.pack(ProcessReport.ENDED, ended[0], os.waitstatus_to_exitcode(ended[1])))


if __name__ == "__main__":
    main(sys.argv[1:])
