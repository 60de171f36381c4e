"""A genuine robot, from nothing to a passing scenario: adopted, bridged and driven."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.router_checks import hidden_peers
from seoro.bridges.session import open_session
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2, running
from tests.routers import free_endpoint

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

SEORO = (sys.executable, "-m", "seoro")
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


@pytest.mark.parametrize("router", ["seoro"], indirect=True)
@pytest.mark.parametrize(
    ("options", "arguments", "status", "lines"),
    [
        (
            {"without": ["cmd_vel", "odom", "amcl_pose", "navigate_to_pose"]},
            (),
            1,
            [
                "failed   ros2/tb: no subscription to /cmd_vel: the driver of the base is not running",
                "failed   ros2/tb: no publisher of /odom: the odometry of the base is not running",
                "warning  ros2/tb: no publisher of /amcl_pose: the localisation is not running",
                "warning  ros2/tb: no server of /navigate_to_pose: the navigation is not running",
            ],
        ),
        (
            {},
            ("--ros-args", "-p", "use_sim_time:=true"),
            1,
            ["failed   ros2/tb: the simulated time of /driver stands still: /clock has no publisher"],
        ),
        ({"ahead": 30.0}, (), 0, [r"warning  ros2/tb: stamps on /\w+ are (29|30)\.\d s ahead of the clock"]),
        (
            {},
            ("--ros-args", "-r", "cmd_vel:=/tb/cmd_vel"),
            1,
            ["failed   ros2/tb: no subscription to /cmd_vel", "found: /tb/cmd_vel"],
        ),
    ],
)
async def test_problems_of_a_robot_are_named(
    ros2: Ros2,
    router: str,
    tmp_path: Path,
    options: dict[str, Any],
    arguments: tuple[str, ...],
    status: int,
    lines: list[str],
) -> None:
    bridge = free_endpoint()
    (tmp_path / "lab.yaml").write_text(f"bridges: {{b: {{connect: {bridge}}}}}\nrobots: {{tb: {{in: b}}}}\n")
    serving = (*SEORO, "bridge", "ros2", "--robot", "turtlebot4:tb", "--ros", router, "--listen", bridge)
    async with mobile(ros2, router, *arguments, **options), running([*serving], "Ctrl-C"):
        out = await run(tmp_path, "doctor", "--lab", "lab.yaml", status=status)
    for line in lines:
        assert re.search(line, out), out


ROUTER = """
import json, sys, time, zenoh
settings = {
    "mode": "router", "listen": {"endpoints": [sys.argv[1]]}, "adminspace": {"enabled": True},
    "scouting": {"multicast": {"enabled": False}},
}
session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
print("up", flush=True)
time.sleep(3600)
"""


async def test_nodes_that_a_newer_router_misses_are_found_on_this_machine(ros2: Ros2, tmp_path: Path) -> None:
    """Nodes of one machine are connected directly. Others are explained."""
    router, explained = free_endpoint(), ""
    async with mobile(ros2, router), running([sys.executable, "-c", ROUTER, router], "up"):
        async with open_session(connect=router) as client:
            with anyio.fail_after(DEADLINE):
                while not (explained := await hidden_peers(client)):
                    await anyio.sleep(0.5)
        assert "has 1 connected peer without visible ROS 2 nodes; since Zenoh 1.9, routers miss" in explained
        out = await run(tmp_path, "ros", "adopt", "--ros", router, "--yes")
        assert "wrote robot.yaml" in out
