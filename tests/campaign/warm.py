"""Fork servers of campaigns that start within milliseconds: they are forked from a process with their modules.

`python -m tests.campaign.warm DESCRIPTOR` is that process; the descriptor is of a socket for requests.
"""

from __future__ import annotations

import asyncio
import fcntl
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final

MODULE: Final = "seoro.campaign.pool.template"
ALSO: Final = ("seoro.bridges.launch", "seoro.bridges.wire.all_messages")  # it loads these for simulators
LARGEST: Final = 1 << 17  # [bytes] of a request
FREE: Final = 500  # first descriptor that no fork server is given


@dataclass
class Forked:
    """Fork server as `asyncio` has processes, as far as its user needs it."""

    pid: int

    async def wait(self) -> None:
        """Wait until it has ended."""
        descriptor, ended = os.pidfd_open(self.pid), asyncio.Event()
        loop = asyncio.get_running_loop()
        loop.add_reader(descriptor, ended.set)
        try:
            await ended.wait()
        finally:
            loop.remove_reader(descriptor)
            os.close(descriptor)

    def kill(self) -> None:
        """Kill it."""
        with suppress(ProcessLookupError):
            os.kill(self.pid, signal.SIGKILL)


class Warm:
    """Process with the modules, which ends with this one."""

    def __init__(self) -> None:
        self._requests, theirs = socket.socketpair(type=socket.SOCK_SEQPACKET)
        with theirs:
            command = [sys.executable, "-m", "tests.campaign.warm", str(theirs.fileno())]
            self._process = subprocess.Popen(command, pass_fds=[theirs.fileno()], start_new_session=True)

    def fork(self, arguments: Sequence[str], descriptors: Sequence[int], environment: Any) -> Forked:
        """Fork a fork server.

        Args:
            arguments: Arguments of its module.
            descriptors: Descriptors that it inherits, with the same numbers.
            environment: Its environment variables.
        """
        request = json.dumps([list(arguments), list(descriptors), str(Path.cwd()), dict(environment)])
        socket.send_fds(self._requests, [request.encode()], [1, 2, *descriptors])
        return Forked(int(self._requests.recv(20)))

    def close(self) -> None:
        """End it."""
        self._requests.close()
        self._process.wait()


def serve(requests: socket.socket) -> list[str] | None:
    """Fork a process for each request.

    Returns:
        The arguments of its module, in a forked process; None at the end of requests.
    """
    while True:
        request, received, _, _ = socket.recv_fds(requests, LARGEST, 20)
        with suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        if not request:
            return None
        process = os.fork()
        if process:
            requests.send(str(process).encode())
            for each in received:
                os.close(each)
            continue
        requests.close()
        os.setsid()
        arguments, descriptors, folder, environment = json.loads(request)
        moved = [fcntl.fcntl(each, fcntl.F_DUPFD, FREE) for each in received]
        for each in received:
            os.close(each)
        for each, wanted in zip(moved, (1, 2, *descriptors), strict=True):
            os.dup2(each, wanted)
            os.close(each)
        os.environ.clear()
        os.environ.update(environment)
        os.chdir(folder)
        sys.path[0] = folder
        return list(arguments)


def main() -> None:
    """Fork processes until the other end closes."""
    modules = [import_module(name) for name in (MODULE, *ALSO)]
    arguments = serve(socket.socket(fileno=int(sys.argv[1])))
    if arguments is not None:
        modules[0].main(arguments)


if __name__ == "__main__":
    main()
