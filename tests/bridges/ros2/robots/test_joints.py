"""Durations of arm motions: from the joint positions and the speed limits; unknown positions are refused."""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.wire.refusal import RequestRefused
from tests.bridges.ros2.robots.test_types import DEADLINE, served
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

JOINTS = "sensor_msgs/msg/JointState"
FOLLOWS = "control_msgs/action/FollowJointTrajectory"
PROFILE = "model: cell\nkinds: [arm]\narm:\n  joints: {a: 1.0, b: 2.0}\n  trajectory: follow\n"
MOTION = wire.FollowJointTrajectory(id="far", robot="cell", points=((-3.0, -3.0),))
NAMES = ["a", "b"]


async def test_arms_move_from_finite_positions_only(
    router: str, types: TypeStore, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.robots.joints.DISCOVERY_TIMEOUT", 0.05)
    (tmp_path / "cell.yaml").write_text(PROFILE)
    durations: list[float] = []
    moved = anyio.Event()

    async def follow(goal: GoalHandle) -> GoalEnd:
        durations.append(geometry.seconds(goal.goal.trajectory.points[-1].time_from_start))
        moved.set()
        return GoalEnd(Status.SUCCEEDED)

    async with (
        two_nodes(router, types) as (there, here),
        serving_action(there, "/follow", FOLLOWS, follow),
        there.publishing("/joint_states", JOINTS) as joints,
        served(here, str(tmp_path / "cell.yaml")) as robot,
    ):

        async def move() -> str:
            """Request the motion, and return the reason of its refusal."""
            try:
                await robot.handlers[wire.FOLLOW_JOINT_TRAJECTORY](MOTION)
            except RequestRefused as refused:
                return refused.message
            return ""

        async def states() -> wire.JointStates | None:
            """Return the positions of the joints, if known."""
            with suppress(RequestRefused):
                found = await robot.handlers[wire.GET_JOINT_STATES](wire.RobotName(robot="cell"))
                assert isinstance(found, wire.JointStates)
                return found
            return None

        with anyio.fail_after(DEADLINE):
            await joints.wait_for_subscription()
            joints.publish({"name": NAMES, "position": [3.0, math.nan]})
            while "the position of the joint 'b' on /joint_states" not in await move():
                assert not durations
            joints.publish({"name": NAMES, "position": [3.0, 3.0]})
            joints.publish({"name": NAMES, "velocity": [0.5, 0.5]})
            while (known := await states()) is None or known.velocities != (0.5, 0.5):
                await anyio.sleep(0.01)
            assert known.positions == (3.0, 3.0)
            assert not await move()
            await moved.wait()
            joints.publish({"name": NAMES, "position": [math.nan, math.inf]})
            while await states() is not None:
                await anyio.sleep(0.01)
            assert "the position of the joint 'a' on /joint_states" in await move()
    assert durations == [pytest.approx(1.5 * 6.0 / 1.0)]
