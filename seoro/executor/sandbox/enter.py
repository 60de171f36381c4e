"""Entry into a sandbox by a process that has already loaded all modules for a run.

A program started in a sandbox would load seoro again, which takes most of a second. So bubblewrap creates the
sandbox around a small process that holds it open, and a forked process joins its namespaces. There are three
processes. The outer one, known to the executor, is the broker and ends with the run. The second one has joined,
and waits. The third one executes the run, in the namespace of processes and without privileges. When the outer one
ends, the sandbox and all its processes end.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import socket
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

from seoro.errors import BackendError

_NEW: Final = {
    "mnt": 0x20000,
    "uts": 0x4000000,
    "ipc": 0x8000000,
    "user": 0x10000000,
    "pid": 0x20000000,
    "net": 0x40000000,
}
_PR_CAPBSET_DROP: Final = 24  # linux/prctl.h
_PR_SET_NO_NEW_PRIVS: Final = 38
_CAPABILITIES_3: Final = 0x20080522  # linux/capability.h
_CAPABILITIES: Final = 64  # more than there are
_libc: Final = ctypes.CDLL(None, use_errno=True)


class Holder:
    """Small process that holds a sandbox open.

    Args:
        command: Command that creates the sandbox.

    Raises:
        BackendError: The sandbox could not be created.
    """

    def __init__(self, command: Sequence[str]) -> None:
        info_read, info_write = os.pipe()
        try:
            self._process = subprocess.Popen(
                [*command, "--info-fd", str(info_write), "cat"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                pass_fds=(info_write,),
                env={"PATH": os.environ.get("PATH", os.defpath)},
            )
        finally:
            os.close(info_write)
        with open(info_read, encoding="utf-8") as file:  # noqa: PTH123 - a descriptor
            info = file.read()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(b".")
            self._process.stdin.flush()
            is_ready = self._process.stdout.read(1) == b"."  # then everything is mounted
        except BrokenPipeError:
            is_ready = False
        if not is_ready:
            raise BackendError(f"cannot create the sandbox of the run (bwrap: status {self._process.wait()})")
        self._first = int(json.loads(info)["child-pid"])

    def join(self) -> None:
        """Join its namespaces; that of processes applies to later forks only."""
        kinds = [kind for kind in _NEW if _differs(self._first, kind)]
        joined = os.pidfd_open(self._first)
        try:
            _check("setns", _libc.setns(joined, sum(_NEW[kind] for kind in kinds)))
        finally:
            os.close(joined)
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            os.close(pipe.fileno())  # or the sandbox would be held open from within


def _differs(process: int, kind: str) -> bool:
    theirs, ours = (Path(f"/proc/{each}/ns/{kind}").readlink() for each in (process, "self"))
    return theirs != ours


@dataclass(frozen=True)
class Outer:
    """Outer process: the sandbox that it holds open, and the process that it waits for."""

    holder: Holder
    process: int


def enter(command: Sequence[str], broker: socket.socket, inside: Sequence[int]) -> Outer | None:
    """Fork a process into a sandbox.

    Args:
        command: Command that creates the sandbox.
        broker: Outer end of the connection between sandbox and broker.
        inside: Descriptors for the process in the sandbox only.

    Returns:
        None in the process in the sandbox.

    Raises:
        BackendError: The sandbox could not be created, in the outer process.
    """
    holder = Holder(command)
    waits = os.fork()
    if waits:
        for each in inside:
            os.close(each)
        return Outer(holder, waits)
    broker.close()
    try:
        holder.join()
        run = os.fork()
    except OSError as error:
        _fail(f"cannot enter the sandbox of the run: {error}")
    if run:
        _wait_for(run)
    _drop_privileges()
    return None


def _fail(reason: str) -> NoReturn:
    os.write(2, f"{reason}\n".encode())
    os._exit(1)


def _wait_for(process: int) -> NoReturn:
    """Close all descriptors, and end as another process does."""
    os.closerange(3, os.sysconf("SC_OPEN_MAX"))
    _, status = os.waitpid(process, 0)
    end_as(os.waitstatus_to_exitcode(status))


def end_as(code: int) -> NoReturn:
    """End this process with the exit status of another, or by its signal if `code` is negative."""
    if code < 0:
        if code not in (-signal.SIGKILL, -signal.SIGSTOP):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(code if code >= 0 else 128 - code)


def _drop_privileges() -> None:
    """Drop all privileges over the namespaces, also for started programs."""
    for capability in range(_CAPABILITIES):
        _libc.prctl(_PR_CAPBSET_DROP, capability, 0, 0, 0)  # of no effect beyond the last one
    header = (ctypes.c_uint32 * 2)(_CAPABILITIES_3, 0)
    _check("capset", _libc.capset(header, (ctypes.c_uint32 * 6)()))
    _check("prctl", _libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))


def _check(name: str, result: int) -> None:
    if result != 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{name}: {os.strerror(number)}")
