"""Runs and users that hold robots of one node: behind a bridge, and in a playing simulator."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import RobotsBusy, connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.session import AsyncSession, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendRefused, UsageError
from seoro.runtime.contracts.backends import GoalStatus, Report
from tests.bridges.robot.conftest import Rails
from tests.lab.nodes import Hall, hall_at
from tests.routers import process
from tests.stopwatch import attempts

pytestmark = pytest.mark.anyio

DRIVER = Path(__file__).with_name("driver.py")
STOPPED = 1e-3  # [m/s]


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hall]:
    with hall_at(tmp_path_factory.mktemp("hall")) as running:
        yield running


async def speed(endpoint: str, robot: str) -> float:
    """Return the true speed of a robot [m/s]."""
    async with open_session(connect=endpoint) as session:
        return await speed_in(session, robot)


async def speed_in(session: AsyncSession, robot: str) -> float:
    """Return the true speed of a robot [m/s] by an open session."""
    address = NodeAddress(session, wire.NAMESPACE, "hall")
    state = await ask(address, wire.GET_ENTITY_STATE, wire.EntityName(name=robot))
    return abs(state.twist.linear.x) + abs(state.twist.linear.y)


async def ended(reports: list[Report]) -> Report:
    with anyio.fail_after(30.0):
        while not reports:
            await anyio.sleep(0.01)
    return reports[0]


async def drive(node: RobotNode, robot: str, duration: float = 0.1) -> Report:
    reports: list[Report] = []
    await node.drive(robot, 0.1, 0.0, duration, reports.append)
    return await ended(reports)


async def both_at_once(endpoint: str, first: str, second: str) -> None:
    """Drive two robots by two clients; each client sees its own robot only."""
    async with (
        connect_robots(endpoint, "one run", robots=(first,)) as one,
        connect_robots(endpoint, "another run", robots=(second,)) as other,
    ):
        assert [[robot.name for robot in node.robots] for node in (one, other)] == [[first], [second]]
        reports: dict[str, list[Report]] = {first: [], second: []}
        for node, robot in ((one, first), (other, second)):
            await node.drive(robot, 0.1, 0.0, 0.3, reports[robot].append)
        for robot in (first, second):
            assert (await ended(reports[robot])).status is GoalStatus.SUCCEEDED
        with pytest.raises(BackendRefused, match=f"the robot '{second}' is held by another run"):
            await one.drive(second, 0.1, 0.0, 0.3, lambda report: None)
        with pytest.raises(RobotsBusy, match=f"'{first}' is held by one run"):
            async with connect_robots(endpoint, "a third run", robots=(first, second)):
                pass


async def test_runs_with_distinct_robots_are_simultaneous_behind_a_bridge(
    start_rails: Callable[..., Rails], tmp_path: Path
) -> None:
    rails = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails", "line", "second")
    await both_at_once(rails.endpoint, "line", "second")


async def test_runs_with_distinct_robots_are_simultaneous_in_a_simulator(hall: Hall) -> None:
    await both_at_once(hall.endpoint, "turtlebot4", "second")


async def test_the_end_of_a_run_does_not_affect_robots_of_another(hall: Hall) -> None:
    reports: list[Report] = []
    async with connect_robots(hall.endpoint, "one run", robots=("turtlebot4",)) as one:
        await one.drive("turtlebot4", 0.1, 0.0, 1.0, reports.append)
        async with connect_robots(hall.endpoint, "another run", robots=("second",)) as other:
            await other.drive("second", 0.1, 0.0, 60.0, lambda report: None)
        assert (await ended(reports)).status is GoalStatus.SUCCEEDED
    with anyio.fail_after(30.0):
        while await speed(hall.endpoint, "second") >= STOPPED:
            pass


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
async def test_a_run_that_dies_or_hangs_stops_its_simulated_robot(hall: Hall, number: signal.Signals) -> None:
    times: list[float] = []
    for _ in attempts(times, 0.5):
        with process(str(DRIVER), hall.endpoint, "turtlebot4", says="drives") as driver:
            async with open_session(connect=hall.endpoint) as session:
                with anyio.fail_after(30.0):
                    while await speed_in(session, "turtlebot4") <= 0.05:
                        pass
                    moment = time.monotonic()
                    driver.send_signal(number)
                    while await speed_in(session, "turtlebot4") > 0.02:
                        pass
            times.append(time.monotonic() - moment)
    assert min(times) < 0.5


async def test_a_playing_simulator_in_use_is_not_reset(hall: Hall) -> None:
    options = SimulatorOptions("hall", 1, ModelPath())
    async with connect_robots(hall.endpoint, "one run", robots=("turtlebot4",)) as node:
        with pytest.raises(RobotsBusy, match="simulator 'hall': 'turtlebot4' is held by one run"):
            async with connect_simulator(hall.endpoint, options, purpose="another run"):
                pass
        assert (await drive(node, "turtlebot4")).status is GoalStatus.SUCCEEDED


@pytest.mark.more
async def test_a_simulator_with_granted_time_is_held_by_one_run(tmp_path: Path) -> None:
    options = SimulatorOptions("hall", 1, ModelPath())
    with hall_at(tmp_path, rate=None) as running:
        with pytest.raises(UsageError, match="time passes here only by the grants of one run"):
            async with connect_robots(running.endpoint, "a run", robots=("second",)):
                pass
        async with connect_simulator(running.endpoint, options, purpose="one run") as node:
            with pytest.raises(RobotsBusy, match="the robots are held by one run"):
                async with connect_simulator(running.endpoint, options, purpose="another run"):
                    pass
            assert await node.advance(0.5) == 0.5
        async with connect_simulator(running.endpoint, options, purpose="another run") as node:
            assert await node.advance(0.5) == 0.5
