"""Robots stop within half a second after a failure of the run that holds them."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from pathlib import Path

import anyio
import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.errors import BackendError
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import GoalStatus, Report
from tests.bridges.robot.conftest import Rails
from tests.routers import process, router_process
from tests.stopwatch import attempts

DEADLINE = 0.5  # [s]
DRIVER = Path(__file__).with_name("driver.py")


def await_motion(rails: Rails) -> None:
    """Wait until the robot drives."""
    started = time.monotonic()
    while rails.commands()[-1][2] == 0.0:
        assert time.monotonic() < started + 20.0, "the robot does not drive"
        time.sleep(0.02)


def stopping_time(rails: Rails, moment: float) -> float:
    """Return the time from a moment to the stop of the robot [s]; wait for it."""
    while (stopped := rails.stopped_after(moment)) is None:
        assert time.monotonic() < moment + 20.0, "the robot still drives"
        time.sleep(0.02)
    return stopped


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_run_that_dies_or_hangs_stops_its_robots(rails: Rails, number: signal.Signals) -> None:
    times: list[float] = []
    for _ in attempts(times, DEADLINE):
        with process(str(DRIVER), rails.endpoint, says="drives") as driver:
            await_motion(rails)
            moment = time.monotonic()
            driver.send_signal(number)
            times.append(stopping_time(rails, moment))
    assert min(times) < DEADLINE


def test_robots_stay_stopped_when_a_hanging_run_resumes(rails: Rails) -> None:
    with process(str(DRIVER), rails.endpoint, says="drives") as driver:
        await_motion(rails)
        driver.send_signal(signal.SIGSTOP)
        stopping_time(rails, time.monotonic())
        driver.send_signal(signal.SIGCONT)
        assert driver.stdout is not None
        assert b"no heartbeat" in driver.stdout.readline()
        assert rails.commands()[-1][2] == 0.0


def test_robots_stop_when_the_router_between_them_and_the_run_dies(
    start_rails: Callable[..., Rails], tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/router"
    times: list[float] = []
    for _ in attempts(times, DEADLINE):
        with router_process(endpoint) as router:
            rails = start_rails("--connect", endpoint)
            with process(str(DRIVER), endpoint, says="drives"):
                await_motion(rails)
                moment = time.monotonic()
                router.kill()
                times.append(stopping_time(rails, moment))
        rails.process.kill()
        rails.process.wait()
        Path(endpoint.partition("/")[2]).unlink()
    assert min(times) < DEADLINE


@pytest.mark.more
@pytest.mark.anyio
async def test_a_run_continues_with_aborted_goals_after_a_restart_of_the_router(
    start_rails: Callable[..., Rails], tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/router"
    reported: list[Report] = []
    lost: list[BackendError] = []
    with router_process(endpoint) as router:
        rails = start_rails("--connect", endpoint)
        async with connect_robots(endpoint, "a run") as node:
            await node.start_run(lambda name, arguments: None, lost.append)
            far = Pose3D(Position3D(x=90.0))
            await node.navigate("line", [far], stop_at_each=False, report=reported.append)
            router.kill()
            router.wait()
            Path(f"{tmp_path}/router").unlink(missing_ok=True)
            with router_process(endpoint):
                with anyio.fail_after(30.0):
                    while not (reported or lost):
                        await anyio.sleep(0.02)
                assert lost == []
                assert reported[0].status is GoalStatus.ABORTED
                assert rails.commands()[-1][2] == 0.0
                again: list[Report] = []
                await node.drive("line", 0.1, 0.0, 0.05, again.append)
                with anyio.fail_after(30.0):
                    while not again:
                        await anyio.sleep(0.02)
                assert again[0].status is GoalStatus.SUCCEEDED
