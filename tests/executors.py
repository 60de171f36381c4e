"""Executors for tests: real ones, in processes of their own."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

NAME = "lab-a"
HELLO = 'import osc.helpers\nscenario hello:\n    do serial:\n        log("hello")\n'
LONG = """import osc.helpers
scenario long:
    do serial:
        log("begun")
        wait elapsed(60s)
"""
MANY = """import osc.helpers
scenario many:
    event tick
    on every(10ms):
        emit tick
    do serial:
        wait elapsed(3s)
"""


@dataclass(frozen=True)
class RunningExecutor:
    """An executor that is running: where it is reached, where its runs are, and its process."""

    endpoint: str
    folder: Path
    process: subprocess.Popen[bytes]

    def kill(self) -> None:
        """As a crash would."""
        self.process.kill()
        self.process.wait()

    def end(self) -> int:
        """As Ctrl-C does."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(20)


@contextmanager
def executor(
    folder: Path,
    *options: str,
    name: str = NAME,
    connect: str | None = None,
    largest: int | None = None,
    before: str = "",
    prefix: Sequence[str] = (),
) -> Iterator[RunningExecutor]:
    """Start an executor, with its socket and its runs in a folder.

    Args:
        folder: The folder.
        options: Options of `seoro serve`.
        name: Its name.
        connect: Endpoint of a router that replaces its socket.
        largest: Size limit of its files [bytes].
        before: Python code to run before the start.
        prefix: Command that runs it.
    """
    endpoint = connect or f"unixsock-stream/{folder}/hub"
    (folder / "hub").unlink(missing_ok=True)  # left by a killed executor
    main = f"import sys\n{before}\nfrom seoro.cli.main import main\nsys.exit(main(sys.argv[1:]))"
    command = [*prefix, sys.executable, "-c", main, "serve", "--name", name]
    command += ["--connect" if connect else "--listen", endpoint, "--folder", str(folder / "state"), *options]
    if largest is not None:
        command = ["prlimit", f"--fsize={largest}", *command]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert b"Ctrl-C" in process.stdout.readline()
            yield RunningExecutor(endpoint, folder, process)
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.send_signal(signal.SIGINT)
                try:
                    process.wait(20)
                except subprocess.TimeoutExpired:
                    process.kill()
