"""Poses of robots without a localisation, for traces."""

from __future__ import annotations

from typing import Any

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.robots.robot import RosRobot
from tests.bridges.ros2.robots.test_types import DEADLINE, POSE, served
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

TF, ODOMETRY = "tf2_msgs/msg/TFMessage", "nav_msgs/msg/Odometry"


def placed(x: float) -> dict[str, Any]:
    return {"pose": {"pose": {"position": {"x": x}, "orientation": {"w": 1.0}}}}


def transform(parent: str, child: str, x: float) -> dict[str, Any]:
    moved = {"translation": {"x": x}, "rotation": {"w": 1.0}}
    return {"transforms": [{"header": {"frame_id": parent}, "child_frame_id": child, "transform": moved}]}


async def until(robot: RosRobot, place: tuple[float | None, float | None, str]) -> None:
    """Wait until x of the estimate, and that of the pose without one with its frame, have values."""
    found: object = None
    with anyio.fail_after(DEADLINE):
        while found != place:
            await anyio.sleep(0.01)
            answer = await robot.handlers[wire.GET_LOCALIZATION](wire.RobotName(robot="tb"))
            assert isinstance(answer, wire.Localization)
            estimate, other = (
                None if pose is None else pose.position.x for pose in (answer.pose, answer.unlocalized)
            )
            found = (estimate, other, answer.unlocalized_frame)


async def test_robots_have_a_pose_by_odometry_until_they_are_localised(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        served(here) as robot,
        there.publishing("/odom", ODOMETRY) as odometry,
        there.publishing("/tf", TF) as frames,
    ):
        await odometry.wait_for_subscription(DEADLINE)
        await frames.wait_for_subscription(DEADLINE)
        odometry.publish(placed(1.0))
        await until(robot, (None, 1.0, "odom"))
        frames.publish(transform("odom", "base_link", 1.5))
        await until(robot, (None, 1.5, "odom"))
        frames.publish(transform("map", "odom", 2.0))  # a localisation without a pose, such as SLAM
        await until(robot, (None, 3.5, "map"))
        async with there.publishing("/amcl_pose", POSE) as localisation:
            await localisation.wait_for_subscription(DEADLINE)
            localisation.publish(placed(9.0))
            await until(robot, (3.5, None, "map"))
