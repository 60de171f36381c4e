"""Processes of seoro that benchmarks measure, for as long as a block lasts."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


@contextmanager
def command(*arguments: str) -> Iterator[int]:
    """Run a command of seoro; yields its process id once it is ready."""
    line = [sys.executable, "-m", "seoro", *arguments]
    # In the session of the benchmark: Linux may group processes by session (`sched_autogroup_enabled`). If both
    # sides of a measurement are busy then, ready threads of one session wait for up to half a second.
    with subprocess.Popen(line, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield process.pid
        finally:
            process.terminate()


@dataclass(frozen=True)
class Executor:
    """An executor that runs: where it is reached, and its process."""

    endpoint: str
    process: int

    @property
    def template(self) -> int:
        """The process that forks runs."""
        return children(self.process)[0]


def processor_time(process: int) -> float:
    """The processor time of a process so far [s]; more precise than wall time on a busy machine."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def children(process: int) -> list[int]:
    """The processes that a process has started."""
    return [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


@contextmanager
def executor(folder: Path, name: str, jobs: int = 1) -> Iterator[Executor]:
    """An executor that keeps its runs in a folder, which also has its socket."""
    endpoint = f"unixsock-stream/{folder}/hub"
    kept = ("--folder", str(folder / "state"), "--jobs", str(jobs))
    with command("serve", "--name", name, "--listen", endpoint, *kept) as process:
        yield Executor(endpoint, process)
