"""Entering a sandbox: a process that has loaded all that a run needs goes into it.

A program that is started in a sandbox would have to load seoro again, which takes most of a second. So bubblewrap
makes the sandbox around a small process that holds it open, and a process that was forked joins its namespaces.
There are three: the outer one, which the executor knows, keeps the broker and ends with the run; one that has
joined, and waits; and the run, which is in the namespace of processes and has no privileges. When the outer one
ends, the sandbox does, and all that is in it.
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
    """A sandbox that is held open.

    Args:
        command: Makes it.

    Raises:
        BackendError: It could not be made.
    """

    def __init__(self, command: Sequence[str]) -> None:
        told, tell = os.pipe()
        try:
            self._process = subprocess.Popen(
                [*command, "--info-fd", str(tell), "cat"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                pass_fds=(tell,),
                env={"PATH": os.environ.get("PATH", os.defpath)},
            )
        finally:
            os.close(tell)
        with open(told, encoding="utf-8") as file:  # noqa: PTH123 - a descriptor
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
            raise BackendError(f"the sandbox of the run could not be made (bwrap: status {self._process.wait()})")
        self._first = int(json.loads(info)["child-pid"])

    def join(self) -> None:
        """Join its namespaces, but for that of processes, which those have that are forked from now on."""
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
    """The outer process: the sandbox that it holds open, and the process that it waits for."""

    holder: Holder
    process: int


def enter(command: Sequence[str], broker: socket.socket, inside: Sequence[int]) -> Outer | None:
    """Go into a sandbox.

    Args:
        command: Makes it.
        broker: The outer end of the connection between the sandbox and the broker.
        inside: Descriptors that only the process in the sandbox needs.

    Returns:
        None in the process that is in the sandbox.

    Raises:
        BackendError: The sandbox could not be made, in the outer process.
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
        _give_up(f"cannot enter the sandbox of the run: {error}")
    if run:
        _wait_for(run)
    _drop_privileges()
    return None


def _give_up(reason: str) -> NoReturn:
    os.write(2, f"{reason}\n".encode())
    os._exit(1)


def _wait_for(process: int) -> NoReturn:
    """End as another process does, and hold nothing open until then."""
    os.closerange(3, os.sysconf("SC_OPEN_MAX"))
    _, status = os.waitpid(process, 0)
    end_as(os.waitstatus_to_exitcode(status))


def end_as(code: int) -> NoReturn:
    """End this process as another did: with its exit status, or killed by its signal if that is negative."""
    if code < 0:
        if code not in (-signal.SIGKILL, -signal.SIGSTOP):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(code if code >= 0 else 128 - code)


def _drop_privileges() -> None:
    """Have no privileges over the namespaces, nor get any from programs that are started."""
    for capability in range(_CAPABILITIES):
        _libc.prctl(_PR_CAPBSET_DROP, capability, 0, 0, 0)  # of no effect beyond the last one
    header = (ctypes.c_uint32 * 2)(_CAPABILITIES_3, 0)
    _check("capset", _libc.capset(header, (ctypes.c_uint32 * 6)()))
    _check("prctl", _libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))


def _check(name: str, result: int) -> None:
    if result != 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{name}: {os.strerror(number)}")
