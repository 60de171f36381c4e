"""Time until ROS 2 robots stop after each kind of end of their run: at most 0.5 s, measured at the robot."""

from __future__ import annotations

import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import anyio
import pytest

from seoro.lab.commands import LabCommands
from tests.bridges.ros2.robots.conftest import BRIDGE, FAKE_ROBOT, Bridged
from tests.routers import free_endpoint, process, router_process
from tests.stopwatch import attempts

DEADLINE = 0.5  # [s]
EMERGENCY_DEADLINE = 0.3  # [s]
DRIVER = str(Path(__file__).with_name("driver.py"))
CANCELED = -5.0


def wait_for(moment: float, when: Callable[[], float | None]) -> float:
    """Wait for an event, and return its time since `moment` [s]."""
    while (found := when()) is None:
        assert time.monotonic() < moment + 20.0, "it has not happened"
        time.sleep(0.02)
    return found - moment


def drives(bridged: Bridged) -> float | None:
    return next((when for when, value in bridged.notes("velocity") if value), None)


def has_goal(bridged: Bridged) -> float | None:
    return next((when for when, value in bridged.notes("goal") if value > 0.0), None)


def goal_ended(bridged: Bridged) -> float | None:
    return next((when for when, value in bridged.notes("goal") if value == CANCELED), None)


def shortest(measured: Callable[[], float], limit: float = DEADLINE) -> float:
    """Return the shortest of some times [s], since a busy machine delays some."""
    times: list[float] = []
    for _ in attempts(times, limit):
        times.append(measured())
    return min(times)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_velocity_commands_end_with_the_run(bridged: Bridged, number: signal.Signals) -> None:
    def measured() -> float:
        began = bridged.begun()
        with process(DRIVER, began.endpoint, began.name, "velocity") as driver:
            wait_for(time.monotonic(), lambda: drives(began))
            moment = time.monotonic()
            driver.send_signal(number)
            return wait_for(moment, began.stopped)

    assert shortest(measured) < DEADLINE


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_navigation_goals_end_with_the_run(bridged: Bridged, number: signal.Signals) -> None:
    def measured() -> float:
        began = bridged.begun()
        with process(DRIVER, began.endpoint, began.name, "goal") as driver:
            wait_for(time.monotonic(), lambda: has_goal(began))
            moment = time.monotonic()
            driver.send_signal(number)
            return wait_for(moment, lambda: goal_ended(began))

    assert shortest(measured) < DEADLINE


@contextmanager
def behind_a_router(folder: Path) -> Iterator[tuple[Bridged, subprocess.Popen[bytes]]]:
    """Yield a robot whose bridge and run are connected to a router of seoro."""
    ros, ours = free_endpoint(), free_endpoint()
    bridge = BRIDGE.replace("listen=listen", "connect=listen")
    with (
        router_process(ros),
        router_process(ours) as router,
        process(str(FAKE_ROBOT), str(folder), ros, "tb", "geometry_msgs/msg/Twist"),
        process("-c", bridge, ros, ours, "tb"),
    ):
        yield Bridged(ours, folder / "tb"), router


@pytest.mark.more
def test_robots_stop_when_the_router_to_the_run_dies(tmp_path: Path) -> None:
    with behind_a_router(tmp_path) as (bridged, router), process(DRIVER, bridged.endpoint, "tb", "velocity"):
        wait_for(time.monotonic(), lambda: drives(bridged))
        moment = time.monotonic()
        router.kill()
        assert wait_for(moment, bridged.stopped) < DEADLINE


def test_an_emergency_stop_sends_zero_in_time(bridged: Bridged) -> None:
    def measured() -> float:
        began = bridged.begun()
        with process(DRIVER, began.endpoint, began.name, "velocity"):
            wait_for(time.monotonic(), lambda: drives(began))
            moment = time.monotonic()
            (outcome,) = anyio.run(LabCommands([began.endpoint]).emergency_stop_all, "a test", "smoke")
            assert outcome.error == ""
            answered = time.monotonic()
            stopped = wait_for(moment, began.stopped) + moment
            anyio.run(LabCommands([began.endpoint]).release_all, "a test", "it is over")
            return stopped - (answered - outcome.elapsed)

    assert shortest(measured, EMERGENCY_DEADLINE) < EMERGENCY_DEADLINE
