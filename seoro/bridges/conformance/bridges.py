"""Rules of bridges to robots: holds, refusals and drives, while the time of the machine passes.

The rules of `hold` move nothing. Those of `drive` move the robot ahead by 15 cm at most.
"""

from __future__ import annotations

import math
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

import anyio

from seoro.bridges import wire
from seoro.bridges.conformance.bench import Reports, expect, expect_refused, expect_reported
from seoro.bridges.robot.connecting import RobotsBusy, connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.robotics.geometry import Pose3D
from seoro.runtime.contracts.backends import GoalStatus, Report

SPEED, DURATION = 0.05, 0.5  # [m/s], [s]
LATE = 3.0  # [s] after which the end of a goal counts as missing


class AwaitedReports(Reports):
    """Reports whose first one can be waited for."""

    def __init__(self) -> None:
        super().__init__()
        self._reported = anyio.Event()

    def __call__(self, report: Report) -> None:
        """Keep a report."""
        super().__call__(report)
        self._reported.set()

    async def wait(self, within: float = DURATION + LATE) -> None:
        """Wait for the first report, `within` [s] at most: by default the time of a drive and `LATE`."""
        with anyio.move_on_after(within):
            await self._reported.wait()


@dataclass
class HeldRobot:
    """A held robot of a bridge.

    Attributes:
        node: The bridge.
        robot: Name of the robot.
        endpoint: Endpoint of the bridge.
        bridge: Name of the bridge; None for the only one.
        start: Pose of the robot before the first rule that navigates.
        posture: Positions of the joints before the first rule that moves the arm.
    """

    node: RobotNode
    robot: str
    endpoint: str
    bridge: str | None = None
    start: Pose3D | None = None
    posture: tuple[float, ...] | None = None

    async def drive(self, report: Callable[[Report], None], duration: float = DURATION) -> str:
        """Drive ahead slowly; return the id of the goal."""
        return await self.node.drive(self.robot, SPEED, 0.0, duration, report)


BridgeRule = Callable[[HeldRobot], Awaitable[None]]


async def held_robots_are_refused_to_others(held: HeldRobot) -> None:
    """A held robot is refused to another client, with a reason."""
    try:
        async with connect_robots(held.endpoint, "another client", held.bridge, (held.robot,)):
            pass
    except RobotsBusy:
        return
    raise AssertionError(f"{held.robot} was held by two clients at once")


async def unknown_robots_are_refused(held: HeldRobot) -> None:
    """Requests for unknown robots are refused."""
    request = held.node.ask(wire.STOP_ROBOT, wire.StopRobot(robot="no_such_robot"))
    await expect_refused("a stop of an unknown robot", request, wire.Result.NOT_FOUND)


async def unserved_verbs_are_refused(held: HeldRobot) -> None:
    """Verbs that the bridge does not list are refused as unsupported."""
    request = held.node.ask(wire.ADVANCE, wire.Advance(until=0.0))
    await expect_refused("a grant of time to a bridge", request, wire.Result.FEATURE_UNSUPPORTED)


async def drives_end_after_their_duration(held: HeldRobot) -> None:
    """A drive succeeds once, after its duration."""
    reports, start = AwaitedReports(), time.monotonic()
    await held.drive(reports)
    await reports.wait()
    took = time.monotonic() - start
    expect_reported(f"a drive of {DURATION:g} s", reports, GoalStatus.SUCCEEDED)
    expect(took > 0.9 * DURATION, f"a drive of {DURATION:g} s ended after {took:.2f} s")


async def driving_robots_are_busy(held: HeldRobot) -> None:
    """A second goal of a driving robot is refused, and the first one succeeds."""
    reports = AwaitedReports()
    await held.drive(reports)
    await expect_refused("a second drive of a driving robot", held.drive(Reports()))
    await reports.wait()
    expect_reported("a drive during which another was refused", reports, GoalStatus.SUCCEEDED)


async def cancelled_drives_end(held: HeldRobot) -> None:
    """A cancelled drive does not succeed, and the robot accepts another goal."""
    first, second = Reports(), AwaitedReports()
    await held.node.cancel_goal(await held.drive(first, 2.0 * DURATION))
    await held.drive(second)
    await second.wait()
    expect_reported("a drive after a cancelled one", second, GoalStatus.SUCCEEDED)
    expect("succeeded" not in first.statuses, "a cancelled drive was reported as succeeded")


async def invalid_drives_are_refused(held: HeldRobot) -> None:
    """Velocities and durations that are not numbers are refused."""
    for speed, duration in ((math.nan, DURATION), (math.inf, DURATION), (0.0, math.nan)):
        request = held.node.drive(held.robot, speed, 0.0, duration, Reports())
        await expect_refused(f"a drive at {speed} m/s for {duration} s", request)


HOLDING: tuple[BridgeRule, ...] = (
    held_robots_are_refused_to_others,
    unknown_robots_are_refused,
    unserved_verbs_are_refused,
)
DRIVING: tuple[BridgeRule, ...] = (
    invalid_drives_are_refused,
    drives_end_after_their_duration,
    driving_robots_are_busy,
    cancelled_drives_end,
)
