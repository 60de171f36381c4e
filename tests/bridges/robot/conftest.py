"""A bridge to a robot on rails in another process."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

LINE_ROBOT = Path(__file__).with_name("line_robot.py")


@dataclass(frozen=True)
class Rails:
    """A bridge that runs: where it is, its process, and the file to which velocities are written."""

    endpoint: str
    process: subprocess.Popen[bytes]
    log: Path

    def commands(self) -> list[tuple[float, str, float]]:
        """All velocities so far: when [s of the machine's clock], of which robot, and which [m/s]."""
        lines = [line.split() for line in self.log.read_text().splitlines()]
        return [(float(when), name, float(velocity)) for when, name, velocity in lines]

    def stopped_after(self, moment: float) -> float | None:
        """How long after a moment [s] zero was commanded; None if the robot still drives."""
        commands = self.commands()
        if commands[-1][2] != 0.0:
            return None
        last_motion = max(index for index, (_, _, velocity) in enumerate(commands) if velocity != 0.0)
        return commands[last_motion + 1][0] - moment


@contextmanager
def rails_at(folder: Path, how: str, endpoint: str, *names: str) -> Iterator[Rails]:
    """A bridge in a process of its own."""
    log = folder / "velocities"
    command = [sys.executable, str(LINE_ROBOT), str(log), how, endpoint, *names]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            yield Rails(endpoint, process, log)
        finally:
            process.kill()


@pytest.fixture
def rails(tmp_path: Path) -> Iterator[Rails]:
    with rails_at(tmp_path, "--listen", f"unixsock-stream/{tmp_path}/rails") as running:
        yield running


@pytest.fixture
def start_rails(tmp_path: Path) -> Iterator[Callable[..., Rails]]:
    with ExitStack() as stack:
        yield lambda how, endpoint, *names: stack.enter_context(rails_at(tmp_path, how, endpoint, *names))
