"""An exposed simulator behind a bridge keeps the rules of robots: both ends of ROS 2 are seoro."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from seoro.bridges.conformance import HeldRobot, bridge_arms, bridge_navigation, check_bridge_rule
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosOptions
from seoro.bridges.ros2.robots.profile import BridgedRobot, read_profile
from seoro.bridges.ros2.robots.running import BridgeOptions, bridging
from tests.bridges.ros2.expose.exposed import exposed
from tests.sim_nodes.client import pose

pytestmark = [pytest.mark.anyio, pytest.mark.engine("mujoco"), pytest.mark.slow]  # in real time

ARM = """model: cell
kinds: [arm]
arm:
  joints:
    shoulder_pan_joint: 2.0
    shoulder_lift_joint: 2.0
    elbow_joint: 3.1
    wrist_1_joint: 3.1
    wrist_2_joint: 3.1
    wrist_3_joint: 3.1
  limits: {shoulder_pan_joint: [-6.2, 6.2]}
  trajectory: joint_trajectory_controller/follow_joint_trajectory
"""


@asynccontextmanager
async def bridged(folder: Path, router: str, name: str, profile: str) -> AsyncIterator[HeldRobot]:
    """Yield a held robot of a bridge to an exposed simulator."""
    endpoint = f"unixsock-stream/{folder}/bridge"
    robot = BridgedRobot(name, read_profile(profile), f"/{name}")
    async with (
        bridging(BridgeOptions([robot], RosOptions(router), listen=endpoint)),
        connect_robots(endpoint, "a test") as node,
    ):
        yield HeldRobot(node, name, endpoint)


async def test_an_exposed_robot_navigates_by_the_rules(
    simulator: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with (
        exposed(simulator, router, types, "empty", 1.0),
        bridged(tmp_path, router, "turtlebot4", "turtlebot4") as held,
    ):
        await held.node.set_initial_pose("turtlebot4", pose(0.0, 0.0))
        for rule in bridge_navigation.NAVIGATING:
            await check_bridge_rule(rule, held)


async def test_an_exposed_arm_moves_by_the_rules(
    simulator: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    profile = tmp_path / "cell.yaml"
    profile.write_text(ARM)
    async with (
        exposed(simulator, router, types, "arm_cell", 1.0),
        bridged(tmp_path, router, "ur10e", str(profile)) as held,
    ):
        for rule in bridge_arms.HANDLING:
            await check_bridge_rule(rule, held)
