"""Emergency stop: robots stand still within 300 ms of the message, and do not move until its release."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import anyio.to_thread
import pytest

import seoro as program
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.session import AsyncSession, SessionError, open_session
from seoro.cli.lab_table import lab_table
from seoro.cli.main import main
from seoro.client import Client
from seoro.errors import BackendError, BackendRefused, BackendStopped, UsageError
from seoro.lab import status
from seoro.lab.commands import LabCommands
from seoro.lab.outcomes import Outcome
from seoro.lab.status import Member
from tests.bridges.robot.conftest import Rails
from tests.executors import LONG, NAME, executor
from tests.lab.nodes import Hall, hall_at
from tests.lab.test_holding import speed
from tests.routers import process
from tests.sim_nodes.engines import make_engine
from tests.stopwatch import attempts

pytestmark = pytest.mark.anyio

WITHIN = 0.3  # [s]
STILL = 0.01  # [m/s]


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hall]:
    with hall_at(tmp_path_factory.mktemp("hall")) as running:
        yield running


def seoro(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "seoro", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)


@asynccontextmanager
async def released(*endpoints: str) -> AsyncIterator[None]:
    """Release all stops after a test."""
    try:
        yield
    finally:
        await LabCommands(endpoints).release_all("a test", "it is over")


async def stop(*endpoints: str) -> list[Outcome]:
    return await LabCommands(endpoints).emergency_stop_all("ana@lab", "smoke")


async def test_a_simulated_robot_stands_still_in_time(hall: Hall) -> None:
    times: list[float] = []
    for _ in attempts(times, WITHIN):
        async with released(hall.endpoint), connect_robots(hall.endpoint, "a run", robots=("second",)) as node:
            lost: list[BackendError] = []
            await node.start_run(lambda name, arguments: None, lost.append)
            await node.drive("second", 0.2, 0.0, 600.0, lambda report: None)
            with anyio.fail_after(30.0):
                while await speed(hall.endpoint, "second") <= 0.1:
                    pass
                began = time.monotonic()
                (outcome,) = await stop(hall.endpoint)
                assert outcome.error == ""
                while await speed(hall.endpoint, "second") > STILL:
                    pass
                times.append(time.monotonic() - began)
                while not lost:
                    await anyio.sleep(0.01)
            assert "no robot may move: emergency stop by ana@lab" in str(lost[0])
            assert isinstance(lost[0], BackendStopped)
    assert min(times) < WITHIN


async def test_a_robot_behind_a_bridge_receives_zero_in_time(rails: Rails) -> None:
    times: list[float] = []
    for _ in attempts(times, WITHIN):
        async with released(rails.endpoint), connect_robots(rails.endpoint, "a run") as node:
            await node.drive("line", 0.2, 0.0, 60.0, lambda report: None)
            while rails.commands()[-1][2] == 0.0:
                await anyio.sleep(0.01)
            began = time.monotonic()
            await stop(rails.endpoint)
            stopped = rails.stopped_after(began)
            assert stopped is not None
            times.append(stopped)
    assert min(times) < WITHIN


async def test_a_silent_endpoint_delays_no_other_stop(rails: Rails, monkeypatch: pytest.MonkeyPatch) -> None:
    slow = ("tcp/127.0.0.1:1", "tcp/127.0.0.1:2")
    has_stopped = anyio.Event()
    times: list[float] = []

    @asynccontextmanager
    async def opening(*, connect: str, security: None) -> AsyncIterator[AsyncSession]:
        times.append(time.monotonic())
        if connect in slow:
            await has_stopped.wait()
            raise SessionError(f"cannot connect to {connect}")
        async with open_session(connect=connect, security=security) as session:
            times.append(time.monotonic())
            yield session
            has_stopped.set()

    async with released(rails.endpoint):
        with anyio.fail_after(30.0), monkeypatch.context() as patched:
            patched.setattr(status, "open_session_at_once", opening)
            outcomes = await stop(slow[0], rails.endpoint, slow[1])
    assert [outcome.display_name for outcome in outcomes] == [slow[0], "the node 'rails'", slow[1]]
    assert outcomes[1].done == "stopped line"
    assert outcomes[1].elapsed >= times[3] - times[0]  # from the beginning, with the time to connect


async def test_no_robot_moves_until_the_stop_is_released(rails: Rails, hall: Hall) -> None:
    endpoints = (rails.endpoint, hall.endpoint)
    async with released(*endpoints):
        assert [outcome.error for outcome in await stop(*endpoints)] == ["", ""]
        for endpoint in endpoints:
            with pytest.raises(UsageError, match=r"emergency stop by ana@lab at .* \(smoke\)"):
                async with connect_robots(endpoint, "a run", robots=()):
                    pass
        outcomes = await LabCommands(endpoints).release_all("bob", " ")
        assert all("missing reason" in outcome.error for outcome in outcomes)
    for endpoint, robot in zip(endpoints, ("line", "second"), strict=True):
        async with connect_robots(endpoint, "a run", robots=(robot,)) as node:
            await node.drive(robot, 0.1, 0.0, 0.1, lambda report: None)


async def test_an_emergency_stop_ends_a_long_grant_of_time(tmp_path: Path) -> None:
    options = SimulatorOptions("hall", 1, ModelPath())
    with hall_at(tmp_path, rate=None) as running:
        async with connect_simulator(running.endpoint, options, purpose="a run") as node:
            lost: list[BackendError] = []
            await node.start_run(lambda name, arguments: None, lost.append)
            await node.drive("second", 0.05, 0.1, 80_000.0, lambda report: None)
            reached: list[float] = []

            async def grant() -> None:
                reached.append(await node.advance(80_000.0))

            async with anyio.create_task_group() as tasks:
                tasks.start_soon(grant)
                await anyio.sleep(0.3)
                (outcome,) = await stop(running.endpoint)
            assert outcome.error == ""
            assert outcome.elapsed < WITHIN
            assert reached[0] < 80_000.0
            with pytest.raises(BackendRefused, match="emergency stop"):
                await node.drive("second", 0.05, 0.1, 1.0, lambda report: None)


async def test_an_emergency_stop_outlasts_a_restart_of_the_bridge(
    start_rails: Callable[..., Rails], tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/rails"
    rails = start_rails("--listen", endpoint)
    await stop(endpoint)
    rails.process.kill()
    rails.process.wait()
    (tmp_path / "rails").unlink()
    start_rails("--listen", endpoint)
    async with released(endpoint):
        with pytest.raises(UsageError, match="emergency stop by ana@lab"):
            async with connect_robots(endpoint, "a run"):
                pass


@pytest.mark.more
async def test_an_emergency_stop_outlasts_restarts_of_named_simulators_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_engine("mujoco")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    endpoint = f"unixsock-stream/{tmp_path}/hall"
    command = ("-m", "seoro", "sim", "mujoco", "--world", "hall", "--listen", endpoint, "--rate", "1")
    with process(*command, says=None):
        assert [outcome.error for outcome in await stop(endpoint)] == [""]
    (tmp_path / "hall").unlink()
    with process(*command, says=None), pytest.raises(UsageError, match="emergency stop by ana@lab"):
        async with connect_robots(endpoint, "a run"):
            pass
    (tmp_path / "hall").unlink()
    with hall_at(tmp_path):  # as runs start theirs
        async with connect_robots(endpoint, "a run"):
            pass


async def test_the_command_lists_nodes_that_have_not_stopped(
    start_rails: Callable[..., Rails], hall: Hall, tmp_path: Path
) -> None:
    rails = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails")
    rails.process.send_signal(signal.SIGSTOP)
    try:
        async with released(hall.endpoint):
            at = ("--connect", hall.endpoint, "--connect", rails.endpoint)
            found = seoro("estop", "--reason", "smoke", *at)
            assert found.returncode == 3
            assert "ok     the node 'hall': stopped turtlebot4, second" in found.stdout
            assert "FAILED" in found.stdout
    finally:
        rails.process.send_signal(signal.SIGCONT)


def test_an_emergency_stop_without_nodes_fails(tmp_path: Path) -> None:
    found = seoro("estop", "--connect", f"unixsock-stream/{tmp_path}/nobody")
    assert found.returncode == 3
    assert "no node was reached" in found.stdout


async def test_the_command_stops_and_releases_named_robots_only(hall: Hall, rails: Rails) -> None:
    at = ("--connect", hall.endpoint, "--connect", rails.endpoint)
    async with (
        released(hall.endpoint, rails.endpoint),
        connect_robots(hall.endpoint, "a run", robots=("second",)) as stopped,
        connect_robots(hall.endpoint, "another run", robots=("turtlebot4",)) as others,
    ):
        lost: list[BackendError] = []
        await stopped.start_run(lambda name, arguments: None, lost.append)
        await others.start_run(lambda name, arguments: None, lambda loss: pytest.fail(str(loss)))
        found = await anyio.to_thread.run_sync(lambda: seoro("estop", "second", "--reason", "smoke", *at))
        assert (found.returncode, found.stdout.split(" (")[0]) == (0, "ok     the node 'hall': stopped second")
        with anyio.fail_after(30.0):
            while not lost:
                await anyio.sleep(0.01)
        assert isinstance(lost[0], BackendStopped)
        assert "the robot 'second' may not move: emergency stop by" in str(lost[0])
        await others.drive("turtlebot4", 0.0, 0.1, 0.1, lambda report: None)
        (state,) = [member.state for member in await status.read_states([hall.endpoint])]
        assert state is not None
        assert {robot.name: robot.stopped is not None for robot in state.robots} == {
            "turtlebot4": False,
            "second": True,
        }
        shown = lab_table([Member(hall.endpoint, "hall", state=state)], (), quiet=())
        assert "EMERGENCY STOP of second of hall by " in shown
        with pytest.raises(UsageError, match="no emergency stop of 'line'"):
            await LabCommands([rails.endpoint]).release_robots([("line", None)], "bob", "toast")
        (outcome,) = await LabCommands([hall.endpoint]).release_robots([("second", None)], "bob", "toast")
        assert outcome.error == ""
    async with connect_robots(hall.endpoint, "a run", robots=("second",)):
        pass


async def test_an_unknown_robot_does_not_prevent_the_stop_of_others(hall: Hall, rails: Rails) -> None:
    endpoints = (hall.endpoint, rails.endpoint)
    places = [("second", None), ("elsewhere", None), ("line", hall.endpoint)]
    async with released(*endpoints):
        outcomes = await LabCommands(endpoints).emergency_stop_robots(places, "ana@lab", "smoke")
        assert [(each.display_name, each.stopped) for each in outcomes if not each.error] == [
            ("the node 'hall'", ("second",))
        ]
        assert {each.display_name: each.error for each in outcomes if each.error} == dict.fromkeys(
            ("elsewhere", "line"),
            "unknown robot (robots of the reached nodes: line, second, turtlebot4)",
        )
        async with connect_robots(rails.endpoint, "a run", robots=("line",)):
            pass


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--estop", "--reason", "x"), "expected robots after `--estop`"),
        (("--all", "tb1"), "cannot be combined with robots"),
        (("tb1", "--reason", "x"), "are for emergency stops"),
        (("--estop", "tb1"), "missing reason of the release"),
        (("--estop", "tb1", "--reason", "x"), "needs a confirmation"),
    ],
)
def test_an_incomplete_release_is_refused(
    arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["lab", "release", *arguments, "--connect", "tcp/127.0.0.1:1"]) == 2
    assert message in capsys.readouterr().err


async def test_an_emergency_stop_makes_an_executor_stop_its_runs_and_start_none(tmp_path: Path) -> None:
    scenario = tmp_path / "long.osc"
    scenario.write_text(LONG)
    with executor(tmp_path) as running:
        async with Client(running.endpoint) as client, released(running.endpoint):
            run = await client.submit(NAME, scenario)
            waiting = await client.submit(NAME, scenario)
            async for record in run.records():
                if record.get("message") == "begun":
                    break
            (outcome,) = await stop(running.endpoint)
            assert outcome.done == f"stopped {run.id[:8]}"
            verdict = await run.result()
            assert verdict.status.value == "cancelled"
            assert "emergency stop by ana@lab" in verdict.reason
            queued = await client.run(waiting.id, NAME)
            assert queued.state.value == "queued"
            assert "emergency stop by ana@lab" in queued.info.waits
            with pytest.raises(BackendError, match="accepts no runs: emergency stop by ana@lab"):
                await client.submit(NAME, scenario)
            await LabCommands([running.endpoint]).release_all("bob", "toast")
            assert not (await client.run(waiting.id, NAME)).info.waits
            async for record in waiting.records():
                if record.get("message") == "begun":
                    break
            await waiting.stop("the test is over")


MOVING = """import osc.helpers
import osc.driving
import osc.robotics
import osc.nav2
import osc.ros
scenario moving:
    leader: differential_drive_robot
    do serial:
        log("begun")
        {act}
"""
FLOOR = "bridges: {{floor: {{connect: {endpoint}}}}}\nrobots: {{leader: {{in: floor, as: line}}}}\n"
ACTS = {
    "one goal": "leader.nav_to_pose(pose_3d(position: position_3d(x: 90m)))",
    "one command after another": """leader.drive(linear: 0.1mps, duration: 20ms) with:
            repeat(10000)
""",
}


@pytest.mark.parametrize("act", ACTS.values(), ids=ACTS)
async def test_a_run_whose_robot_is_stopped_is_cancelled(rails: Rails, tmp_path: Path, act: str) -> None:
    scenario, lab = tmp_path / "moving.osc", tmp_path / "lab.yaml"
    scenario.write_text(MOVING.format(act=act))
    lab.write_text(FLOOR.format(endpoint=rails.endpoint))
    async with (
        released(rails.endpoint),
        program.start(program.load(scenario), lab=program.Lab(lab), clock="real") as run,
    ):
        with anyio.fail_after(30.0):
            while rails.commands()[-1][2] == 0.0:
                await anyio.sleep(0.01)
        await stop(rails.endpoint)
        verdict = await run.result()
    assert verdict.status.value == "cancelled"
    assert "no robot may move: emergency stop by ana@lab" in verdict.reason


async def test_an_emergency_stop_cancels_a_run_that_grants_time(tmp_path: Path) -> None:
    scenario = tmp_path / "long.osc"
    scenario.write_text(LONG.replace("60s", "80000s"))
    with hall_at(tmp_path, rate=None) as running:
        simulator = program.Simulator(endpoint=running.endpoint, world="hall", rate=1.0)
        async with program.start(program.load(scenario), simulator=simulator) as run:
            async for record in run.trace():
                if record.get("message") == "begun":
                    break
            await stop(running.endpoint)
            verdict = await run.result()
    assert verdict.status.value == "cancelled"
    assert "emergency stop by ana@lab" in verdict.reason


@pytest.mark.more
async def test_a_remote_run_is_cancelled_if_only_its_robot_is_stopped(rails: Rails, tmp_path: Path) -> None:
    scenario, lab = tmp_path / "moving.osc", tmp_path / "lab.yaml"
    scenario.write_text(MOVING.format(act=ACTS["one goal"]))
    lab.write_text(FLOOR.format(endpoint=rails.endpoint))
    with executor(tmp_path) as running:
        async with Client(running.endpoint) as client, released(rails.endpoint):
            run = await client.submit(NAME, scenario, lab=program.Lab(lab), clock="real")
            with anyio.fail_after(30.0):
                while rails.commands()[-1][2] == 0.0:
                    await anyio.sleep(0.01)
            await stop(rails.endpoint)
            verdict = await run.result()
            assert verdict.status.value == (await client.run(run.id, NAME)).state.value == "cancelled"
            assert "emergency stop by ana@lab" in verdict.reason
