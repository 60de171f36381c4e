"""What is done with robots of a lab after a run, which still holds them: they drive home, are put somewhere, or
carry out a scenario.
"""

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
from seoro.lab.resetting import Resetting
from seoro.lab.schema import PlaceFile
from seoro.runtime.contracts import GoalStatus, Orientation3D, Pose3D, Position3D, Report, Velocity6D

STEP = 0.5  # [s] of simulated time that are granted at a time on the way home
PUT_WITHIN = 5.0  # [s]

NOT_DONE = "the robot '%s' was not left in order after the run: %s"

log = logging.getLogger(__name__)


class Aftermath:
    """What a lab says of the robots of a run for its end.

    Args:
        lab: The lab.
        nodes: Where they live, by their names in the lab.
        resets: Scenarios by which they are left in order, for those that have one.

    `follows` says that the run has begun; else the robots are where they were.
    """

    def __init__(
        self, lab: Lab, nodes: Mapping[str, SimulatorNode | RobotNode], resets: Mapping[str, Resetting]
    ) -> None:
        self._lab = lab
        self._nodes = nodes
        self._resets = resets
        self.follows = False
        self._scope = anyio.CancelScope(shield=True)

    def cut_short(self) -> None:
        """Have nothing done any more; what is being done ends at once."""
        self._scope.cancel()

    @asynccontextmanager
    async def following(self) -> AsyncIterator[None]:
        """Do it after the block, however that ends."""
        try:
            yield
        finally:
            with self._scope:
                for robot in self._nodes if self.follows else ():
                    await self._leave(robot)

    async def _leave(self, robot: str) -> None:
        """Leave one robot in order; what goes wrong is said, and does not change how the run has ended."""
        after, node, called = self._lab.robots[robot].after, self._nodes[robot], self._lab.called(robot)
        if after is None:
            return
        try:
            await anyio.lowlevel.checkpoint()  # a run begins all the same when it is cancelled
            if robot in self._resets:
                await self._resets[robot].carry_out()
            elif after.home is not None:
                await _drive_home(called, node, after.home, after.within)
            elif after.place is not None and isinstance(node, SimulatorNode):
                with anyio.fail_after(PUT_WITHIN):
                    await node.set_entity_state(called, _pose(after.place), Velocity6D())
            else:
                log.warning("the robot '%s' cannot be put anywhere: it is no simulated one", robot)
        except (BackendError, TimeoutError) as error:
            if not self._scope.cancel_called:
                log.warning(NOT_DONE, robot, error or "it takes too long")
        finally:
            if self._scope.cancel_called:
                log.warning(NOT_DONE, robot, "that was cut short")


async def _drive_home(robot: str, node: SimulatorNode | RobotNode, home: PlaceFile, within: float) -> None:
    told: list[Report] = []
    lost: list[BackendError] = []
    over = anyio.Event()

    def tell(report: Report) -> None:
        told.append(report)
        over.set()

    def lose(error: BackendError) -> None:
        lost.append(error)
        over.set()

    await node.start_run(lambda name, arguments: None, lose)
    if lost:
        raise lost[0]
    goal = await node.navigate(robot, [_pose(home)], stop_at_each=False, report=tell)
    try:
        with anyio.fail_after(within):
            if isinstance(node, SimulatorNode):
                await _grant(node, over, within)
            else:
                await over.wait()
    except BaseException:
        with anyio.CancelScope(shield=True), suppress(BackendError):
            await node.cancel_goal(goal)
        raise
    if lost:
        raise lost[0]
    if told and told[0].status is not GoalStatus.SUCCEEDED:
        raise BackendError(told[0].message)


async def _grant(node: SimulatorNode, over: anyio.Event, within: float) -> None:
    """Let simulated time pass until a goal is over, for so long at most [s]."""
    end = node.time + within
    while not over.is_set():
        if node.time >= end:
            raise TimeoutError
        await node.advance(min(node.time + STEP, end))


def _pose(place: PlaceFile) -> Pose3D:
    return Pose3D(Position3D(x=place.x, y=place.y), Orientation3D(yaw=place.yaw))
