"""A genuine robot, from nothing to a passing scenario: adopted, bridged and driven."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest

from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2, running
from tests.routers import free_endpoint

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

SEORO = (sys.executable, "-m", "seoro.cli.main")
SCENARIO = """
import osc.driving
import osc.helpers
import osc.nav2

scenario first:
    timeout(60s)
    ROBOT: differential_drive_robot
    do serial:
        ROBOT.drive(linear: 0.2mps, duration: 1s)
        ROBOT.init_nav2(pose_3d(position_3d(x: 1m)))
        ROBOT.nav_to_pose(pose_3d(position_3d(x: 1.5m)))
"""


async def run(folder: Path, *arguments: str, status: int = 0) -> str:
    """Run a command of seoro in a folder, and return its output."""
    with anyio.fail_after(DEADLINE):
        done = await anyio.run_process([*SEORO, *arguments], stderr=subprocess.STDOUT, check=False, cwd=folder)
    output = done.stdout.decode()
    assert done.returncode == status, output
    return output


@asynccontextmanager
async def mobile(ros2: Ros2, router: str, *arguments: str, **options: Any) -> AsyncIterator[None]:
    """Run a genuine mobile robot during the block."""
    program = Path(__file__).with_name("mobile.py")
    command = [str(ros2.folder / "run"), str(program), json.dumps(options), *arguments]
    async with running(command, "ready", {"ROUTER": router}):
        yield


@pytest.mark.parametrize(("namespace", "stamped"), [("", False), ("/tb1", True)])
async def test_an_adopted_robot_passes_a_scenario(
    ros2: Ros2, router: str, tmp_path: Path, namespace: str, stamped: bool
) -> None:
    bridge, name = free_endpoint(), namespace.strip("/") or "robot"
    remap = ("--ros-args", "-r", f"__ns:={namespace}", "-r", "tf:=/tf") if namespace else ()
    (tmp_path / "first.osc").write_text(SCENARIO.replace("ROBOT", name))
    async with mobile(ros2, router, *remap, stamped=stamped):
        out = await run(tmp_path, "ros", "adopt", "--ros", router, "--bridge", bridge, "-o", "lab", "--yes")
        [command] = [line.split() for line in out.splitlines() if line.startswith("  seoro bridge ros2")]
        assert "linear: 0.5" in (tmp_path / "lab" / f"{name}.yaml").read_text()  # a parameter of the node
        serving = [*SEORO, *(str(tmp_path / word) if word.startswith("lab/") else word for word in command[1:])]
        async with running(serving, "Ctrl-C"):
            await run(tmp_path, "doctor", "--lab", "lab/lab.yaml")
            await run(tmp_path, "exec", "first.osc", "--lab", "lab/lab.yaml")
