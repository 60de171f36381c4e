"""State of a robot: it is dropped when its publisher disappears."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.robots.localisation import POSE
from seoro.bridges.ros2.robots.profile import read_profile
from seoro.bridges.ros2.robots.robot import RosRobot
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import LATCHED
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.wire.refusal import RequestRefused
from tests.bridges.ros2.robots.test_types import DEADLINE, served
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

JOINTS = "sensor_msgs/msg/JointState"


def placed(x: float) -> dict[str, object]:
    return {"pose": {"pose": {"position": {"x": x}, "orientation": {"w": 1.0}}}}


async def where(robot: RosRobot) -> wire.Pose3D | None:
    """Return an estimated pose."""
    found = await robot.handlers[wire.GET_LOCALIZATION](wire.RobotName(robot="tb"))
    assert isinstance(found, wire.Localization)
    return found.pose


@asynccontextmanager
async def localised(router: str, types: TypeStore) -> AsyncIterator[tuple[RosRobot, Publication]]:
    """Yield a robot and the publisher of its pose."""
    async with (
        two_nodes(router, types) as (there, here),
        served(here) as robot,
        there.publishing("/amcl_pose", POSE, LATCHED) as localisation,
    ):
        await localisation.wait_for_subscription(DEADLINE)
        yield robot, localisation


async def test_the_pose_of_a_lost_localisation_is_dropped(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (there, here), served(here) as robot:
        with anyio.fail_after(DEADLINE):
            for x in (7.0, 8.0):
                assert robot.health.localised is False
                async with there.publishing("/amcl_pose", POSE, LATCHED) as localisation:
                    localisation.publish(placed(x))
                    while (pose := await where(robot)) is None:
                        await anyio.sleep(0.01)
                    assert pose.position.x == x
                while await where(robot) is not None:
                    await anyio.sleep(0.01)


@pytest.mark.parametrize(
    "nowhere",
    [
        {"pose": {"position": {"x": math.nan}}},
        {"pose": {"orientation": {"w": math.nan}}},
        {"covariance": [math.nan, *[0.0] * 35]},
    ],
    ids=lambda nowhere: next(iter(nowhere)),
)
async def test_an_invalid_pose_of_a_localisation_is_dropped(
    nowhere: dict[str, object], router: str, types: TypeStore
) -> None:
    async with localised(router, types) as (robot, localisation):
        with anyio.fail_after(DEADLINE):
            localisation.publish(placed(7.0))
            while not robot.health.localised:
                await anyio.sleep(0.01)
            localisation.publish({"pose": nowhere})
            while robot.health.localised:
                await anyio.sleep(0.01)
            assert await where(robot) is None
            assert robot.health.deviation is None
            why = {topic.topic: topic.why for topic in robot.health.topics}["/amcl_pose"]
            assert why.startswith("invalid pose on /amcl_pose")


async def test_negative_variances_give_no_deviation(router: str, types: TypeStore) -> None:
    unsure = {"pose": {"pose": {"orientation": {"w": 1.0}}, "covariance": [-1.0, *[0.0] * 35]}}
    async with localised(router, types) as (robot, localisation):
        localisation.publish(unsure)
        with anyio.fail_after(DEADLINE):
            while not robot.health.localised:
                await anyio.sleep(0.01)
        assert robot.health.deviation is None


async def test_joints_of_a_lost_arm_need_new_positions(
    router: str, types: TypeStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.robots.joints.DISCOVERY_TIMEOUT", 0.05)
    arm, events = read_profile("ur10e").arm, EventLog()
    assert arm is not None
    assert arm.gripper is not None
    names = (*arm.joints, arm.gripper.joint)
    watch = wire.WatchJoint(id="watch", robot="arm", joint=names[0], position=0.0, tolerance=0.01)

    async def is_at(position: float | None) -> None:
        """Wait until all joints are at a position, or unknown for None."""
        found: float | None = math.nan
        while found != position:
            await anyio.sleep(0.01)
            try:
                states = await robot.handlers[wire.GET_JOINT_STATES](wire.RobotName(robot="arm"))
            except RequestRefused as refused:
                assert "no state of the joint" in refused.message
                found = None
            else:
                assert isinstance(states, wire.JointStates)
                found = states.positions[-1]

    async with two_nodes(router, types) as (there, here), served(here, "ur10e", events) as robot:
        with anyio.fail_after(DEADLINE):
            async with there.publishing("/joint_states", JOINTS) as joints:
                await joints.wait_for_subscription()
                joints.publish({"name": names, "position": [0.5] * len(names)})
                await is_at(0.5)
                await robot.handlers[wire.WATCH_JOINT](watch)
            await is_at(None)
            async with there.publishing("/joint_states", JOINTS) as joints:
                await joints.wait_for_subscription()
                joints.publish({"name": names, "position": [-0.5] * len(names)})
                await is_at(-0.5)
                assert events.number == 0  # on the other side, but it has not come there past the position
                joints.publish({"name": names, "position": [0.0] * len(names)})
                await events.after(wire.AwaitEvents(since=0, wait=DEADLINE))
    assert events.number == 1
