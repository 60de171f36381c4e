"""Runs of scenarios on a ROS 2 system: a router, and a robot in a process of its own."""

import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Protocol

import anyio
import pytest

from seoro.bridges.session import Session
from seoro.embed import prepare
from seoro.embed.options import Options, Ros
from seoro.embed.runs import Run
from seoro.runtime.actions import ActionFunction
from tests.runtime.conftest import Ran, load_text


def free_endpoint() -> str:
    """An endpoint at which nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@contextmanager
def routing() -> Iterator[str]:
    """The endpoint of a router, such as rmw_zenohd is one."""
    endpoint = free_endpoint()
    hub = Session(listen=endpoint)
    try:
        yield endpoint
    finally:
        hub.close()


@pytest.fixture
def router() -> Iterator[str]:
    """The endpoint of a router behind which nobody is."""
    with routing() as endpoint:
        yield endpoint


@contextmanager
def starting_robot(router: str) -> Iterator[subprocess.Popen[str]]:
    """A robot that is ready."""
    command = [sys.executable, "-m", "tests.actions.ros2.robot", router]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == "ready\n"
            yield process
        finally:
            process.kill()


@pytest.fixture(scope="session")
def robot() -> Iterator[str]:
    """The endpoint of a router behind which a robot is."""
    with routing() as endpoint, starting_robot(endpoint):
        yield endpoint


class RunRos(Protocol):
    async def __call__(self, text: str, actions: Sequence[ActionFunction] = ()) -> Ran: ...


def options(endpoint: str, interfaces: Sequence[Path] = ()) -> Options:
    return Options(seed=0, ros=Ros(endpoint, dialect="rmw_zenoh", interfaces=interfaces))


@asynccontextmanager
async def running(
    folder: Path, endpoint: str, text: str, actions: Sequence[ActionFunction] = ()
) -> AsyncIterator[Run]:
    """A run of the text of a scenario."""
    scenario = load_text(folder, "import osc.ros\n" + text, actions)
    async with prepare(scenario, options(endpoint)) as run, run.running():
        yield run


@pytest.fixture
def run_ros(tmp_path: Path, robot: str) -> RunRos:
    """Runs the text of a scenario on the robot."""

    async def run_it(text: str, actions: Sequence[ActionFunction] = ()) -> Ran:
        with anyio.fail_after(60.0):  # which no test should take, however busy the machine is
            async with running(tmp_path, robot, text, actions) as run:
                return await ran_of(run)

    return run_it


async def ran_of(run: Run) -> Ran:
    records = [record async for record in run.trace()]
    return Ran(await run.result(), records)
