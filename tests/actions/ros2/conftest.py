"""Runs of scenarios on a ROS 2 system: a router, and a robot in a process of its own."""

import re
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Protocol

import anyio
import pytest

from seoro.embed import prepare
from seoro.embed.options import Options, Ros
from seoro.embed.runs import Run
from seoro.runtime.functions.actions import ActionFunction
from seoro.runtime.verdict import RunStatus, Verdict
from tests.routers import routing
from tests.runtime.conftest import Ran, load_text


@pytest.fixture
def router() -> Iterator[str]:
    """Endpoint of a router without peers."""
    with routing() as endpoint:
        yield endpoint


RMW_ZENOH = "rmw_zenoh"


@contextmanager
def starting_robot(router: str, module: str = "robot", *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A robot that is ready."""
    command = [sys.executable, "-m", f"tests.actions.ros2.{module}", router, *arguments]
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


def options(endpoint: str, interfaces: Sequence[Path] = (), dialect: str | None = RMW_ZENOH) -> Options:
    return Options(seed=0, ros=Ros(endpoint, dialect=dialect, interfaces=interfaces))


@asynccontextmanager
async def running(
    folder: Path, endpoint: str, text: str, actions: Sequence[ActionFunction] = (), dialect: str | None = RMW_ZENOH
) -> AsyncIterator[Run]:
    """A run of the text of a scenario."""
    scenario = load_text(folder, "import osc.ros\n" + text, actions)
    async with prepare(scenario, options(endpoint, dialect=dialect)) as run, run.running():
        yield run


@pytest.fixture
def run_ros(tmp_path: Path, robot: str) -> RunRos:
    """Runs the text of a scenario on the robot."""

    async def run_it(text: str, actions: Sequence[ActionFunction] = ()) -> Ran:
        with anyio.fail_after(60.0):  # longer than any test takes on a busy machine
            async with running(tmp_path, robot, text, actions) as run:
                return await ran_of(run)

    return run_it


def failing_after(action: str, *steps: str) -> str:
    """The body of a scenario: an action that runs until other steps are over, and then the run fails."""
    indent = 12 * " "
    return f"    do parallel:\n        {action}\n        serial:\n" + "".join(
        f"{indent}{step}\n" for step in (*steps, "emit fail")
    )


async def ran_of(run: Run) -> Ran:
    records = [record async for record in run.trace()]
    return Ran(await run.result(), records)


async def run_with_a_robot_that_dies(folder: Path, router: str, text: str) -> Verdict:
    """Return the result of a run whose robot is killed after its first log."""
    with starting_robot(router) as process:
        async with running(folder, router, text) as run:
            async for record in run.trace():
                if record["kind"] == "log":
                    process.kill()
                    break
            return await run.result()


def expect_failure(verdict: Verdict, reason: str) -> None:
    """A run has failed, for a reason that a regular expression finds."""
    assert verdict.status is RunStatus.FAILED
    assert re.search(reason, verdict.reason), verdict.reason
