"""Suspended bridges: after their guard has stopped the robots, resumed bridges do not drive them."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import anyio
import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosOptions
from seoro.bridges.ros2.robots import running
from seoro.bridges.ros2.robots.guard_state import STOOD_STILL, GuardState, Standstills
from seoro.bridges.ros2.robots.profile import BridgedRobot, read_profile
from seoro.bridges.ros2.robots.running import BridgeOptions, bridging
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import GoalStatus
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.robots.conftest import Bridged
from tests.bridges.ros2.robots.test_ending import Commands
from tests.bridges.ros2.robots.test_guard import alone
from tests.bridges.ros2.robots.test_safety import drives, goal_ended, has_goal
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio


async def test_a_drive_ends_with_a_standstill(
    router: str, types: TypeStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    standstills, commands, end = Standstills(), Commands(), Ends()
    state = GuardState(standstills)
    monkeypatch.setattr(running, "guarded", lambda _: nullcontext(state))
    monkeypatch.setattr("seoro.bridges.ros2.robots.guard_state.SILENCE", 0.05)
    monkeypatch.setattr("seoro.bridges.ros2.robots.velocity.STOPPING", 0.2)
    endpoint = f"unixsock-stream/{tmp_path}/bridge"
    options = BridgeOptions(
        [BridgedRobot("tb", read_profile("turtlebot4"), "/tb")], RosOptions(router), listen=endpoint
    )
    async with two_nodes(router, types) as (base, _), anyio.create_task_group() as tasks:
        await tasks.start(commands.take, base)
        async with bridging(options), connect_robots(endpoint, "a test") as node:
            await node.drive("tb", 0.2, 0.0, 60.0, end)
            await commands.wait()
            standstills.note_heartbeat()  # no other one follows, and no guard stops the robot
            report = await end.wait()
        tasks.cancel_scope.cancel()
    assert (report.status, report.message) == (GoalStatus.ABORTED, STOOD_STILL)
    velocities = [velocity for _, velocity in commands.taken]
    assert 0.2 not in velocities[velocities.index(0.0) :]


def test_each_standstill_is_counted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr("seoro.bridges.ros2.robots.guard_state.time.monotonic", lambda: now)
    standstills = Standstills()
    now = 5.0
    assert standstills.number == 0  # before the first heartbeat of the guard
    standstills.note_heartbeat()
    now = 5.2
    standstills.note_heartbeat()
    now = 5.4
    assert standstills.number == 0
    now = 9.0
    assert (standstills.number, standstills.number) == (1, 1)
    standstills.note_heartbeat()
    now = 9.4
    standstills.note_heartbeat()
    assert standstills.number == 2
    standstills.note_end()
    now = 20.0
    assert standstills.number == 2


async def until(when: Callable[[], float | None]) -> None:
    """Wait for a condition while the run continues."""
    with anyio.fail_after(30.0):
        while when() is None:
            await anyio.sleep(0.02)


@pytest.mark.more
@pytest.mark.parametrize(
    ("how", "begun", "over"), [("velocity", drives, Bridged.stopped), ("goal", has_goal, goal_ended)]
)
async def test_robots_stand_still_when_a_suspended_bridge_resumes(
    how: str,
    begun: Callable[[Bridged], float | None],
    over: Callable[[Bridged], float | None],
    tmp_path: Path,
) -> None:
    end = Ends()
    with alone(tmp_path) as robot:
        async with connect_robots(robot.bridged.endpoint, "a test") as node:
            if how == "velocity":
                await node.drive("tb", 0.2, 0.0, 60.0, end)
            else:
                await node.navigate("tb", [Pose3D(Position3D(x=90.0))], stop_at_each=False, report=end)
            await until(lambda: begun(robot.bridged))
            robot.bridge.send_signal(signal.SIGSTOP)
            await until(lambda: over(robot.bridged))
            moment = time.monotonic()
            robot.bridge.send_signal(signal.SIGCONT)
            report = await end.wait()
            assert (report.status, report.message) == (GoalStatus.ABORTED, STOOD_STILL)
            await anyio.sleep(0.3)
            assert not any(value for when, value in robot.bridged.notes("velocity") if when > moment)
            await node.drive("tb", 0.1, 0.0, 0.1, again := Ends())
            assert (await again.wait()).status is GoalStatus.SUCCEEDED
