"""Genuine nodes for tests: an environment with rclpy and rmw_zenoh_cpp, and processes in it.

`setup.sh` creates the environment once for each version of its requirements. It is in the folder
`SEORO_ROS2_RUNTIME`, by default `../shared/ros2`. Without this folder, the tests are skipped.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio
import pytest
from anyio.abc import Process
from anyio.streams.text import TextReceiveStream

from tests.routers import free_endpoint

ROOT = Path(__file__).parents[4]
NODE = Path(__file__).with_name("node.py")
SETUP = Path(os.environ.get("SEORO_ROS2_RUNTIME", ROOT.parent / "shared" / "ros2")) / "setup.sh"
MADE_WITHIN = 900.0  # [s]
DEADLINE = 90.0  # [s] limit of steps that take a second on an idle machine


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark all tests of this folder: they need the runtime."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.ros2)


@pytest.fixture(scope="session")
def genuine() -> Path:
    """Return the folder of an environment with ROS 2."""
    if not SETUP.exists():
        pytest.skip(f"runtime of ROS 2 not found: {SETUP} is missing")
    return environment(SETUP)


def environment(setup: Path) -> Path:
    """Return the folder of the environment that a `setup.sh` makes; it is made once."""
    version = hashlib.sha256(setup.read_bytes() + setup.with_name("requirements.txt").read_bytes()).hexdigest()[
        :12
    ]
    folder = Path(tempfile.gettempdir()) / f"seoro-ros2-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    with _locked(folder / f"{version}.lock"):
        made, complete = folder / version, folder / f"{version}.complete"
        if not complete.exists():
            subprocess.run(["bash", str(setup), str(made)], check=True, timeout=MADE_WITHIN, capture_output=True)
            complete.touch()
    return made


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock against other processes."""
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@dataclass(frozen=True)
class Running:
    """A process and its output."""

    process: Process
    lines: AsyncIterator[str]

    async def printed(self, text: str) -> str:
        """Wait for a line that contains a text, and return it."""
        with anyio.fail_after(DEADLINE):
            async for line in self.lines:
                if text in line:
                    return line
        raise AssertionError(f"the process ended and did not print {text!r}")


async def _lines(process: Process) -> AsyncIterator[str]:
    assert process.stdout is not None
    rest = ""
    async for text in TextReceiveStream(process.stdout):
        *whole, rest = (rest + text).split("\n")
        for line in whole:
            yield line


@asynccontextmanager
async def killed_at_end(process: Process) -> AsyncIterator[None]:
    """Kill a process at the end of the block, unless it has ended."""
    try:
        yield
    finally:
        with anyio.CancelScope(shield=True):
            if process.returncode is None:
                process.kill()
            await process.aclose()


@asynccontextmanager
async def running(
    command: list[str], begun: str, environment: dict[str, str] | None = None
) -> AsyncIterator[Running]:
    """Yield a process that has printed a line with a text; kill it at the end of the block."""
    own = {**os.environ, **(environment or {})}
    process = await anyio.open_process(command, stdin=subprocess.DEVNULL, stderr=subprocess.STDOUT, env=own)
    async with killed_at_end(process):
        started = Running(process, _lines(process))
        await started.printed(begun)
        yield started


@dataclass(frozen=True)
class Ros2:
    """Genuine nodes, and routers."""

    folder: Path

    def node(self, router: str, *arguments: str) -> AbstractAsyncContextManager[Running]:
        """Yield a ready node; see `node.py`."""
        command = [str(self.folder / "run"), str(NODE), *arguments]
        return running(command, "ready", {"ROUTER": router})

    @asynccontextmanager
    async def router(self, kind: str, endpoint: str) -> AsyncIterator[Running]:
        """Yield a router of `seoro` or of rmw_zenoh (`zenoh 1.8.0`)."""
        if kind == "seoro":
            command = [sys.executable, "-m", "seoro", "router", "--listen", endpoint]
            async with running(command, "Ctrl-C") as router:
                yield router
            return
        port = endpoint.rpartition(":")[2]
        async with running([str(self.folder / "router"), port], "router up") as router:
            yield router


@pytest.fixture
def ros2(genuine: Path) -> Ros2:
    return Ros2(genuine)


@pytest.fixture(params=["seoro", "zenoh 1.8.0"])
async def router(request: pytest.FixtureRequest, ros2: Ros2) -> AsyncIterator[str]:
    """Yield the endpoint of a router of each kind."""
    endpoint = free_endpoint()
    async with ros2.router(request.param, endpoint):
        yield endpoint
