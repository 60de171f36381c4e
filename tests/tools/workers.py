"""Processes that run command lines in a checkout; see `trace_worker.py`."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

SCRIPT: Final = Path(__file__).with_name("trace_worker.py")
START_LIMIT: Final = 30.0  # [s] for the first answer


class WorkerFailed(Exception):
    """A worker does not answer; the message is the reason."""


class Worker:
    """A process that runs command lines with the `seoro` of a checkout, started when it is needed.

    Args:
        checkout: Folder of the checkout.
        limit: Wall time of a command line [s].
    """

    def __init__(self, checkout: Path, limit: float) -> None:
        self._checkout = checkout.resolve()
        self._limit = limit
        self._process: subprocess.Popen[bytes] | None = None

    def send(self, arguments: Sequence[str], folder: Path) -> None:
        """Begin to run a command line, whose output goes to a folder."""
        process = self._process or self._start()
        assert process.stdin is not None
        process.stdin.write(json.dumps([list(arguments), str(folder)]).encode() + b"\n")

    def receive(self) -> str:
        """Return the exit status; or the reason of a failure, after ending the process."""
        try:
            return self._answer(self._limit)
        except WorkerFailed as failure:
            self.stop()
            return str(failure)

    def stop(self) -> None:
        """End the process with its children."""
        if self._process is not None:
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.communicate()
            self._process = None

    def _start(self) -> subprocess.Popen[bytes]:
        """Start the process.

        Raises:
            WorkerFailed: `seoro` is missing, or imported from another place.
        """
        removed = ("PYTHONDONTWRITEBYTECODE", "PYTHONSAFEPATH")
        kept = {key: value for key, value in os.environ.items() if key not in removed}
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(SCRIPT)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
            start_new_session=True,
            # Sets of strings have the same order in both checkouts.
            env={**kept, "PYTHONPATH": str(self._checkout), "PYTHONHASHSEED": "0"},
        )
        found = json.loads(self._answer(START_LIMIT))
        if not Path(found).is_relative_to(self._checkout):
            self.stop()
            raise WorkerFailed(f"seoro comes from {found}, expected it in {self._checkout}")
        return self._process

    def _answer(self, limit: float) -> str:
        assert self._process is not None and self._process.stdout is not None
        if not select.select([self._process.stdout], [], [], limit)[0]:
            raise WorkerFailed(f"no end within {limit:g} s")
        line = self._process.stdout.readline()
        if not line:
            raise WorkerFailed(f"the process ended with {self._process.wait()}")
        return line.decode().strip()
