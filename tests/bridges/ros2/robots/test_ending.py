"""End of a bridge of ROS 2 robots."""

from __future__ import annotations

import time
from contextlib import nullcontext
from pathlib import Path

import anyio
import pytest
from anyio.abc import TaskStatus

from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, RosOptions
from seoro.bridges.ros2.robots.guard_state import GuardState
from seoro.bridges.ros2.robots.profile import BridgedRobot, read_profile
from seoro.bridges.ros2.robots.running import BridgeOptions, bridging
from seoro.bridges.ros2.robots.velocity import STOPPING
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

TWIST = "geometry_msgs/msg/Twist"
DEADLINE = 30.0  # [s]


class Commands:
    """Commanded velocities of a base: time [s, machine clock] and velocity [m/s]."""

    def __init__(self) -> None:
        self.taken: list[tuple[float, float]] = []
        self._came = anyio.Event()

    async def take(self, base: RosNode, *, task_status: TaskStatus[None]) -> None:
        async with base.subscribing("/tb/cmd_vel", TWIST) as subscription:
            task_status.started()
            async for received in subscription:
                self.taken.append((time.monotonic(), subscription.decode(received).linear.x))
                self._came.set()

    async def wait(self) -> None:
        """Wait for the first velocity."""
        with anyio.fail_after(DEADLINE):
            await self._came.wait()


@pytest.mark.parametrize("how", ["is asked to end", "is interrupted"])
async def test_an_ending_bridge_repeats_zero_for_half_a_second(
    how: str, router: str, types: TypeStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The guard, a process that takes a second to start, has nothing to do where the bridge ends by itself.
    monkeypatch.setattr("seoro.bridges.ros2.robots.running.guarded", lambda _: nullcontext(GuardState()))
    endpoint, commands, ends = f"unixsock-stream/{tmp_path}/bridge", Commands(), anyio.Event()
    options = BridgeOptions(
        [BridgedRobot("tb", read_profile("turtlebot4"), "/tb")], RosOptions(router), listen=endpoint
    )
    bridge = anyio.CancelScope()

    async def serve(*, task_status: TaskStatus[None]) -> None:
        with bridge:
            async with bridging(options):
                task_status.started()
                await ends.wait()

    async with two_nodes(router, types) as (base, _), anyio.create_task_group() as tasks:
        await tasks.start(commands.take, base)
        async with anyio.create_task_group() as bridges:
            await bridges.start(serve)
            async with connect_robots(endpoint, "a test") as node:
                await node.drive("tb", 0.2, 0.0, 60.0, Ends())
                await commands.wait()
                if how == "is interrupted":
                    bridge.cancel()
                else:
                    ends.set()
        tasks.cancel_scope.cancel()
    zeros = [when for when, velocity in commands.taken if velocity == 0.0]
    assert zeros[-1] - zeros[0] > STOPPING / 2.0
    assert commands.taken[-1][1] == 0.0
