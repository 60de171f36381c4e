"""A bridge to a robot on rails in another process."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from seoro.security.keys import VARIABLE
from tests.routers import process

LINE_ROBOT = Path(__file__).with_name("line_robot.py")


@dataclass(frozen=True)
class Rails:
    """A running bridge: endpoint, process, and file with the commanded velocities.

    `before` is the number of velocities from before the test.
    """

    endpoint: str
    process: subprocess.Popen[bytes]
    log: Path
    before: int = 0

    def begun(self) -> Rails:
        """Return a copy that ignores earlier commands."""
        return replace(self, before=len(self.log.read_text().splitlines()))

    def commands(self) -> list[tuple[float, str, float]]:
        """Return the last earlier and all later velocities: time [s, machine clock], robot and velocity [m/s]."""
        lines = [line.split() for line in self.log.read_text().splitlines()[max(0, self.before - 1) :]]
        return [(float(when), name, float(velocity)) for when, name, velocity in lines]

    def stopped_after(self, moment: float) -> float | None:
        """Return the time from a moment to the command of zero [s]; None if the robot still drives."""
        commands = self.commands()
        if commands[-1][2] != 0.0:
            return None
        last_motion = max(index for index, (_, _, velocity) in enumerate(commands) if velocity != 0.0)
        return commands[last_motion + 1][0] - moment


@contextmanager
def rails_at(folder: Path, how: str, endpoint: str, *names: str, keys: Path | None = None) -> Iterator[Rails]:
    """Yield a bridge in its own process, with keys for TLS endpoints."""
    log = folder / "velocities"
    own = None if keys is None else {VARIABLE: str(keys)}
    with process(str(LINE_ROBOT), str(log), how, endpoint, *names, environment=own) as running:
        yield Rails(endpoint, running, log)


@pytest.fixture(scope="module")
def all_rails(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rails]:
    folder = tmp_path_factory.mktemp("rails")
    with rails_at(folder, "--listen", f"unixsock-stream/{folder}/rails") as running:
        yield running


@pytest.fixture
def rails(all_rails: Rails) -> Rails:
    """Yield a bridge that several tests share."""
    return all_rails.begun()


@pytest.fixture
def start_rails(tmp_path: Path) -> Iterator[Callable[..., Rails]]:
    with ExitStack() as stack:
        yield lambda how, endpoint, *names: stack.enter_context(rails_at(tmp_path, how, endpoint, *names))
