"""Teardown of lab robots after a run that still holds them: driving home, moving, or a scenario."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress

import anyio
import anyio.lowlevel

from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import BackendError
from seoro.lab.reading import Lab
from seoro.lab.resetting import ResetRun
from seoro.lab.schema import PlaceFile
from seoro.robotics.geometry import Orientation3D, Pose3D, Position3D, Velocity6D
from seoro.runtime.contracts.backends import GoalStatus, Report

STEP = 0.5  # [s] simulated time of each grant on the way home
MOVE_TIMEOUT = 5.0  # [s]

FAILED = "teardown of the robot '%s' failed: %s"

log = logging.getLogger(__name__)


class Teardown:
    """Teardown of the robots of a run.

    Args:
        lab: The lab.
        nodes: Nodes of the robots, by their names in the lab.
        resets: Reset scenarios, by the names of their robots in the lab.

    Attributes:
        is_due: Set when the run has started; before that, the robots have not moved.
    """

    def __init__(
        self, lab: Lab, nodes: Mapping[str, SimulatorNode | RobotNode], resets: Mapping[str, ResetRun]
    ) -> None:
        self._lab = lab
        self._nodes = nodes
        self._resets = resets
        self.is_due = False
        self._scope = anyio.CancelScope(shield=True)

    def abort(self) -> None:
        """Cancel the teardown."""
        self._scope.cancel()

    @asynccontextmanager
    async def after_block(self) -> AsyncIterator[None]:
        """Tear down the robots after the block, on every path."""
        try:
            yield
        finally:
            with self._scope:
                for robot in self._nodes if self.is_due else ():
                    await self._tear_down(robot)

    async def _tear_down(self, robot: str) -> None:
        """Tear down one robot. Failures are logged, and do not change the result of the run."""
        after, node, name = self._lab.robots[robot].after, self._nodes[robot], self._lab.remote_name(robot)
        if after is None:
            return
        try:
            await anyio.lowlevel.checkpoint()  # else a reset scenario would start in spite of a cancellation
            if robot in self._resets:
                await self._resets[robot].run()
            elif after.home is not None:
                await _drive_home(name, node, after.home, after.within)
            elif after.place is not None and isinstance(node, SimulatorNode):
                with anyio.fail_after(MOVE_TIMEOUT):
                    await node.set_entity_state(name, _pose(after.place), Velocity6D())
            else:
                log.warning(FAILED, robot, "`place` requires a simulated robot")
        except (BackendError, TimeoutError) as error:
            if not self._scope.cancel_called:
                log.warning(FAILED, robot, error or "it takes too long")
        finally:
            if self._scope.cancel_called:
                log.warning(FAILED, robot, "cancelled")


async def _drive_home(robot: str, node: SimulatorNode | RobotNode, home: PlaceFile, within: float) -> None:
    reports: list[Report] = []
    lost: list[BackendError] = []
    over = anyio.Event()

    def end(report: Report) -> None:
        reports.append(report)
        over.set()

    def lose(error: BackendError) -> None:
        lost.append(error)
        over.set()

    await node.start_run(lambda name, arguments: None, lose)
    if lost:
        raise lost[0]
    goal = await node.navigate(robot, [_pose(home)], stop_at_each=False, report=end)
    try:
        with anyio.fail_after(within):
            if isinstance(node, SimulatorNode):
                await _advance_until(node, over, within)
            else:
                await over.wait()
    except BaseException:
        with anyio.CancelScope(shield=True), suppress(BackendError):
            await node.cancel_goal(goal)
        raise
    if lost:
        raise lost[0]
    if reports and reports[0].status is not GoalStatus.SUCCEEDED:
        raise BackendError(reports[0].message)


async def _advance_until(node: SimulatorNode, over: anyio.Event, within: float) -> None:
    """Grant simulated time until a goal is over, at most for a duration [s]."""
    end = node.time + within
    while not over.is_set():
        if node.time >= end:
            raise TimeoutError
        await node.advance(min(node.time + STEP, end))


def _pose(place: PlaceFile) -> Pose3D:
    return Pose3D(Position3D(x=place.x, y=place.y), Orientation3D(yaw=place.yaw))
