"""A genuine node reads the sensors of an exposed simulator."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.runtime.contracts.backends import GoalStatus
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.expose.exposed import exposed
from tests.bridges.ros2.expose.test_sensors import PLACE, SENSORS
from tests.bridges.ros2.genuine.conftest import Ros2, running
from tests.bridges.ros2.robots.test_sensing import PROFILE
from tests.routers import free_endpoint
from tests.sim_nodes.engines import needs_pictures
from tests.sim_nodes.sensors.bench import room_with

pytestmark = [pytest.mark.anyio, pytest.mark.ros2, pytest.mark.engine("mujoco")]


async def test_a_genuine_node_reads_all_sensors(
    ros2: Ros2, simulator: str, types: TypeStore, tmp_path: Path
) -> None:
    needs_pictures("mujoco")
    endpoint = free_endpoint()
    async with (
        ros2.router("zenoh 1.8.0", endpoint),
        exposed(simulator, endpoint, types, room_with(tmp_path, SENSORS, PLACE), rate=1.0),
        ros2.node(endpoint, "viewer", "/turtlebot4") as viewer,
    ):
        sensed = json.loads((await viewer.printed("sensed")).partition("sensed ")[2])
    assert sensed["front/image_raw"][:5] == [640, 480, 1920, "rgb8", 640 * 480 * 3]
    assert sensed["front/image_raw"][5] > 100  # not black
    assert sensed["front/camera_info"] == pytest.approx([640, 480, 240 / math.tan(0.48), 239.5])
    assert sensed["top/points"][:3] == ["x", "y", "z"]
    assert sensed["top/points"][3:] == pytest.approx([3.0, 0.0, 0.0], abs=0.05)
    assert sensed["nose/range"] == pytest.approx([0, 4.0, 2.8], abs=0.05)
    frame, weight = sensed["mast/wrench"]
    assert (frame, weight < -1.0) == ("rplidar_link", True)
    assert sensed["gps/fix"] == pytest.approx([0, 48.1, 11.6, 1.0], abs=1e-4)


async def test_a_run_waits_for_the_force_of_a_genuine_node(ros2: Ros2, router: str, tmp_path: Path) -> None:
    profile, end = tmp_path / "rover.yaml", Ends()
    profile.write_text(PROFILE)
    endpoint = f"unixsock-stream/{tmp_path}/bridge"
    bridge = [sys.executable, "-m", "seoro", "bridge", "ros2", "--robot", f"{profile}:rover"]
    async with (
        ros2.node(router, "presser", "wrist/wrench"),
        running([*bridge, "--ros", router, "--listen", endpoint], endpoint),
        connect_robots(endpoint, "a test", robots=("rover",)) as node,
    ):
        await node.watch_force("rover", "wrist", 20.0, end)
        assert (await end.wait()).status is GoalStatus.SUCCEEDED
