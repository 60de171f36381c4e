"""Killed and interrupted processes: runs end, and no process or file remains."""

import os
import signal
import time
from pathlib import Path

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.session import open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.cli.main import main
from tests.integration.conftest import (
    OBSTACLE,
    StartSeoro,
    is_alive,
    read_trace,
    wait_for_driving,
    wait_until,
)

pytestmark = pytest.mark.engine("mujoco")


def test_the_death_of_the_simulator_ends_the_run_as_an_error(start_seoro: StartSeoro, tmp_path: Path) -> None:
    process = start_seoro("exec", OBSTACLE, "--sim", "mujoco", "-o", str(tmp_path))
    node = wait_for_driving(process)
    killed = time.monotonic()
    os.kill(node, signal.SIGKILL)
    _, err = process.communicate(timeout=30)
    assert time.monotonic() - killed < 8.0, "silence is noticed later"
    assert process.returncode == 3
    assert "simulator 'mujoco' died during the run (killed by SIGKILL)" in err
    assert "Traceback" not in err
    assert not is_alive(node)
    assert read_trace(tmp_path / "trace.jsonl")[-1]["status"] == "error"


def test_ctrl_c_cancels_cleans_up_and_leaves_no_node(start_seoro: StartSeoro, tmp_path: Path) -> None:
    process = start_seoro("exec", OBSTACLE, "--sim", "mujoco", "-o", str(tmp_path))
    node = wait_for_driving(process)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "interrupted by Ctrl-C" in err
    assert not is_alive(node)
    ended = read_trace(tmp_path / "trace.jsonl")[-1]
    assert (ended["status"], ended["reason"]) == ("cancelled", "interrupted by Ctrl-C")


@pytest.mark.more
def test_ctrl_c_during_the_start_of_the_simulator_ends_the_run(start_seoro: StartSeoro) -> None:
    process = start_seoro("exec", OBSTACLE, "--sim", "mujoco")
    wait_until(lambda: Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(), 30.0)
    node = int(Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()[0])
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "Traceback" not in err
    wait_until(lambda: not is_alive(node), 3)


def test_a_killed_run_takes_its_simulator_with_it(start_seoro: StartSeoro) -> None:
    process = start_seoro("exec", OBSTACLE, "--sim", "mujoco")
    node = wait_for_driving(process)
    arguments = Path(f"/proc/{node}/cmdline").read_text().split("\0")
    folder = Path(arguments[arguments.index("--folder") + 1])
    assert folder.is_dir()
    process.kill()
    wait_until(lambda: not is_alive(node), 30.0)
    assert not folder.exists()


@pytest.mark.more
def test_a_manually_started_simulator_outlives_runs(start_seoro: StartSeoro, tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/node.sock"
    node = start_seoro("sim", "mujoco", "--listen", endpoint)
    assert node.stdout is not None
    assert endpoint in node.stdout.readline()
    for _ in range(2):
        run = start_seoro("exec", OBSTACLE, "--connect", endpoint, "--rate", "max", "--seed", "1")
        _, err = run.communicate(timeout=60)
        assert run.returncode == 0, err
    assert node.poll() is None
    node.send_signal(signal.SIGINT)
    assert node.wait(30.0) == 0


@pytest.mark.more
def test_a_run_uses_the_world_of_a_connected_simulator(start_seoro: StartSeoro, tmp_path: Path) -> None:
    (tmp_path / "hall.yaml").write_text(
        "name: hall\nextent: [-3, -3, 3, 3]\nwalls: []\nrobots:\n  - {name: turtlebot4, robot: turtlebot4}\n"
    )
    endpoint = f"unixsock-stream/{tmp_path}/node.sock"
    node = start_seoro("sim", "mujoco", "--listen", endpoint, "--world", str(tmp_path / "hall.yaml"))
    assert node.stdout is not None
    assert "the world hall" in node.stdout.readline()
    run = start_seoro("exec", OBSTACLE, "--connect", endpoint, "--dry-run")
    _, err = run.communicate(timeout=20)
    assert run.returncode == 0, err
    run = start_seoro("exec", OBSTACLE, "--connect", endpoint, "--rate", "max", "--timeout", "0.01")
    out, _ = run.communicate(timeout=20)
    assert "world 'hall'" in out


@pytest.mark.more
def test_an_interrupted_run_leaves_the_robot_standing(start_seoro: StartSeoro, tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/node.sock"
    node = start_seoro("sim", "mujoco", "--listen", endpoint)
    assert node.stdout is not None
    node.stdout.readline()
    run = start_seoro("exec", OBSTACLE, "--connect", endpoint, "--rate", "8")
    assert run.stdout is not None
    for line in run.stdout:
        if "> robot.nav_to_pose" in line:
            break
    anyio.run(wait_until_driven, endpoint)
    run.send_signal(signal.SIGINT)
    run.communicate(timeout=30)
    assert run.returncode == 130

    async def slide() -> float:
        async with open_session(connect=endpoint) as session:
            address = NodeAddress(session, "default", "mujoco")
            features = await ask(address, wire.GET_SIMULATOR_FEATURES, wire.Empty())
            before = await position(address)
            await ask(address, wire.ADVANCE, wire.Advance(until=features.time + 2.0))
            after = await position(address)
            return abs(after.x - before.x) + abs(after.y - before.y)

    assert anyio.run(slide) < 0.1


async def position(address: NodeAddress) -> wire.Position3D:
    """Return the position of the robot."""
    robot = wire.EntityName(name="turtlebot4")
    return (await ask(address, wire.GET_ENTITY_STATE, robot)).pose.position


async def wait_until_driven(endpoint: str) -> None:
    """Wait until the robot is more than 0.3 m from its start."""
    async with open_session(connect=endpoint) as session:
        address = NodeAddress(session, "default", "mujoco")
        with anyio.fail_after(60):
            while (at := await position(address)).x + at.y <= 0.3:
                await anyio.sleep(0.02)


def test_a_failed_simulator_start_is_reported_with_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mujoco").mkdir()
    (tmp_path / "mujoco" / "__init__.py").write_text("raise ImportError('a library is missing')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert main(["exec", OBSTACLE, "--sim", "mujoco"]) == 3
    err = capsys.readouterr().err
    assert (
        err
        == "error: the simulator node 'mujoco' did not start (exit status 1: ImportError: a library is missing)\n"
    )
