"""Remains of runs in their process, in others, and at their simulator, after each kind of end."""

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import pytest

import seoro
from seoro.bridges import wire
from seoro.bridges.session import open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendRefused
from tests.embedding.conftest import holdings, left_of_simulations
from tests.integration.conftest import StartSeoro, children, is_alive, marked, wait_until
from tests.integration.test_embedding import folders

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.helpers
import osc.ros
import osc.gazebo
import osc.own

scenario main:
    how: string = "last"
    robot: differential_drive_robot
    box: sim_object
    do serial:
        run_process("{program}", wait_for_shutdown: false)
        robot.init_nav2(pose_3d(position_3d(x: 0.0m, y: 0.0m)))
        box.spawn(pose_3d(position_3d(x: 2.0m, y: -2.0m, z: 0.1m)), 'example_simulation://models/box.sdf')
        parallel:
            robot.nav_to_pose(pose_3d(position_3d(x: 3.0m, y: -3.0m)))
            robot.tf_close_to(reference_point: position_3d(x: 3.0m, y: -3.0m), threshold: 0.1m)
            block()
            hold(how)
            serial:
                wait elapsed(1s)
                log("all is there")
                finish(how)
                emit end
"""
DECLARATIONS = """
action block
action hold:
    how: string
action finish:
    how: string
"""
LIBRARY = """
import asyncio
from pathlib import Path

from seoro import ActionContext, ActionFailed, ThreadContext, action


@action("block", thread=True)
def block(ctx: ThreadContext) -> None:
    while True:
        ctx.sleep(0.1)


@action("hold")
async def hold(ctx: ActionContext, how: str) -> None:
    server = await asyncio.start_server(lambda _, writer: writer.close(), "127.0.0.1", 0)
    try:
        async with server, asyncio.TaskGroup() as group:
            group.create_task(asyncio.sleep(3600))
            with Path(__file__).open():
                await ctx.sleep(3600)
    finally:
        if how == "hang":
            await asyncio.sleep(3600)


@action("finish")
async def finish(ctx: ActionContext, how: str) -> None:
    match how:
        case "pass":
            return
        case "fail":
            raise ActionFailed("no use")
        case "break":
            raise KeyError("bug")
        case _:
            await ctx.sleep(3600)
"""
PROGRAM = """#!/bin/sh
export MARK={mark}
(setsid sleep 1000 &)
sleep 1000 &
wait
"""
STARTED = 2  # processes that outlive the program by design


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Write a scenario whose run uses all kinds of resources after a second."""
    program = tmp_path / "program"
    program.write_text(PROGRAM.format(mark=tmp_path))
    program.chmod(0o755)
    (tmp_path / "main.osc").write_text(SCENARIO.replace("{program}", str(program)))
    (tmp_path / "seoro.libraries").mkdir()
    (tmp_path / "seoro.libraries" / "own.osc").write_text(DECLARATIONS)
    (tmp_path / "seoro.libraries" / "own.py").write_text(LIBRARY)
    return tmp_path


@pytest.fixture(scope="module")
def endpoint(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Run a manually started simulator; return its endpoint."""
    found = f"unixsock-stream/{tmp_path_factory.mktemp('node')}/node.sock"
    command = [sys.executable, "-m", "seoro", "sim", "mujoco", "--listen", found]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as node:
        assert node.stdout is not None
        node.stdout.readline()
        yield found
        node.send_signal(signal.SIGINT)


# ---------------------------------------------------------------- remains of runs


async def left_at(endpoint: str) -> list[str]:
    """Return the remains of a run at a simulator."""
    async with open_session(connect=endpoint) as session:
        address = NodeAddress(session, "default", "mujoco")
        names = (await ask(address, wire.GET_ENTITIES, wire.EntityFilter())).names
        left = ["an entity"] if "box" in names else []
        for number in range(1, 4):
            goal, watch = wire.CancelGoal(id=f"goal-{number}"), wire.CancelWatch(id=f"watch-{number}")
            left += ["a goal"] if await _is_there(ask(address, wire.CANCEL_GOAL, goal)) else []
            left += ["a watch"] if await _is_there(ask(address, wire.CANCEL_WATCH, watch)) else []
        return left + (["a velocity"] if await _moves(address) else [])


async def _is_there(cancelled: Awaitable[wire.Empty] | Awaitable[wire.CancelledWatch]) -> bool:
    try:
        await cancelled
    except BackendRefused as refused:
        assert refused.code == wire.Result.NOT_FOUND
        return False
    return True


async def _moves(address: NodeAddress) -> bool:
    """Return whether the robot drives when time passes."""
    robot = wire.EntityName(name="turtlebot4")
    now = (await ask(address, wire.GET_SIMULATOR_FEATURES, wire.Empty())).time
    before = (await ask(address, wire.GET_ENTITY_STATE, robot)).pose.position
    await ask(address, wire.ADVANCE, wire.Advance(until=now + 2.0))
    after = (await ask(address, wire.GET_ENTITY_STATE, robot)).pose.position
    return abs(after.x - before.x) + abs(after.y - before.y) > 0.1


# ---------------------------------------------------------------- runs of a program

End = Callable[[seoro.Run], None]


@asynccontextmanager
async def nothing_left(mark: str, endpoint: str | None) -> AsyncIterator[None]:
    """Expect that runs in the block leave nothing behind."""
    held, temporary = holdings(), folders()
    yield
    assert not await left_of_simulations(held)
    assert not folders() - temporary
    assert not marked(mark)
    if endpoint is not None:
        assert await left_at(endpoint) == []


def stop(run: seoro.Run) -> None:
    """Stop the run."""
    run.stop("enough")


def cancel(_: seoro.Run) -> None:
    """Cancel the task of the program."""
    task = asyncio.current_task()
    assert task is not None
    task.cancel()


def leave(_: seoro.Run) -> None:
    """Raise an error of the program."""
    raise LookupError


def go_on(_: seoro.Run) -> None:
    """Let the run end."""


async def carry(
    folder: Path, simulator: seoro.Simulator, how: str, end: End, runs: list[seoro.Run]
) -> seoro.Verdict:
    """Run a scenario; call a function once the run uses all resources."""
    scenario = seoro.load(folder / "main.osc")
    overrides = {"how": f'"{how}"'}
    async with seoro.start(scenario, seed=1, simulator=simulator, overrides=overrides) as run:
        runs.append(run)
        async for record in run.trace():
            if record["kind"] == "log" and record["message"] == "all is there":
                wait_until(lambda: len(marked(f"MARK={folder}")) == STARTED, 30.0)
                end(run)
        return await run.result()


@pytest.mark.parametrize(
    ("how", "end", "status"),
    [
        ("pass", go_on, seoro.RunStatus.PASSED),
        ("fail", go_on, seoro.RunStatus.FAILED),
        ("break", go_on, seoro.RunStatus.ERROR),
        ("last", stop, seoro.RunStatus.CANCELLED),
        ("last", cancel, seoro.RunStatus.CANCELLED),
        ("last", leave, seoro.RunStatus.CANCELLED),
    ],
)
async def test_an_embedded_run_leaves_nothing_behind(
    how: str, end: End, status: seoro.RunStatus, folder: Path, endpoint: str
) -> None:
    await left_at(endpoint)  # Zenoh keeps some files for the process
    runs: list[seoro.Run] = []
    simulator = seoro.Simulator(endpoint=endpoint)
    async with nothing_left(f"MARK={folder}", endpoint):
        task = asyncio.create_task(carry(folder, simulator, how, end, runs))
        with suppress(asyncio.CancelledError, LookupError):
            await task
    verdict = runs[0].verdict
    assert verdict is not None
    assert verdict.status is status
    reported = {each.path.rpartition("/")[2].partition("[")[0] for each in verdict.cancelled}
    if end is not go_on:
        assert {"robot.nav_to_pose", "robot.tf_close_to", "block", "hold"} <= reported
    assert all(each.clean_up < 5.0 and not each.overran for each in verdict.cancelled)


# ---------------------------------------------------------------- runs of the command


def start_run(start_seoro: StartSeoro, folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Start a run; return once it uses all resources."""
    run = start_seoro("exec", str(folder / "main.osc"), *arguments, "--rate", "1")
    assert run.stdout is not None
    assert any("all is there" in line for line in run.stdout)
    wait_until(lambda: len(marked(f"MARK={folder}")) == STARTED, 30.0)
    return run


@pytest.mark.parametrize("how", ["last", "hang"])
def test_ctrl_c_once_or_twice_leaves_nothing_behind(
    how: str, folder: Path, endpoint: str, start_seoro: StartSeoro
) -> None:
    mine = folders()
    run = start_run(start_seoro, folder, "--connect", endpoint, "--set", f'how="{how}"')
    run.send_signal(signal.SIGINT)
    if how == "hang":
        assert run.stdout is not None
        assert any("cleaning up" in line for line in run.stdout)
        run.send_signal(signal.SIGINT)
    run.communicate(timeout=30)
    assert run.returncode == 130
    wait_until(lambda: not marked(f"MARK={folder}"), 3)
    assert not folders() - mine
    assert asyncio.run(left_at(endpoint)) == []


@pytest.mark.parametrize(("arguments", "number", "code"), [((), signal.SIGTERM, 4), (("--timeout", "4"), None, 3)])
def test_a_signal_or_time_limit_leaves_nothing_behind(
    arguments: tuple[str, ...],
    number: int | None,
    code: int,
    folder: Path,
    endpoint: str,
    start_seoro: StartSeoro,
) -> None:
    run = start_run(start_seoro, folder, "--connect", endpoint, *arguments)
    if number is not None:
        run.send_signal(number)
    run.communicate(timeout=30)
    assert run.returncode == code
    wait_until(lambda: not marked(f"MARK={folder}"), 3)
    assert asyncio.run(left_at(endpoint)) == []


@pytest.mark.more
def test_the_death_of_the_simulator_leaves_nothing_behind(folder: Path, start_seoro: StartSeoro) -> None:
    mine = folders()
    run = start_run(start_seoro, folder, "--sim", "mujoco")
    [node] = children(run.pid)
    os.kill(node, signal.SIGKILL)
    run.communicate(timeout=30)
    assert run.returncode == 3
    wait_until(lambda: not marked(f"MARK={folder}"), 3)
    assert not is_alive(node)
    assert not folders() - mine
