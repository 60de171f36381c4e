"""The process of a fork server.

A request is a byte with two descriptors for the new process: of the pipe from its user, and of the socket to its
user. The second socket of the server reports which process was started, and how a process ended.
"""

from __future__ import annotations

import gc
import os
import select
import signal
import socket
import threading
from contextlib import suppress
from typing import Final

from seoro.concurrency.forks.reports import REPORT, ProcessReport

DESCRIPTORS: Final = 2  # with a request


def serve_forks(requests: int, reports: int) -> tuple[int, int] | None:
    """Fork processes until the other end closes the socket for requests. Call it after all modules are loaded.

    Args:
        requests: Descriptor of the socket for requests.
        reports: Descriptor of the socket for reports.

    Returns:
        The two descriptors of a request, in a forked process; None in the fork server, at its end.
    """
    for each in (requests, reports):
        os.set_inheritable(each, False)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # meant for the user of the processes
    assert threading.active_count() == 1, "locks of other threads would stay locked in forked processes"
    gc.collect()
    gc.freeze()  # else garbage collection would copy shared pages
    with socket.socket(fileno=requests) as connection, suppress(BrokenPipeError):  # the other end has died
        return _make_processes(connection, reports)
    return None


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
