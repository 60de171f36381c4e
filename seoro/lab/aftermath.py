"""What is done with robots of a lab after a run, which still holds them: they drive home, or are put somewhere."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager

import anyio

from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import BackendError
from seoro.lab.reading import Lab
from seoro.lab.schema import AfterFile, PlaceFile
from seoro.runtime.contracts import GoalStatus, Orientation3D, Pose3D, Position3D, Report, Velocity6D

STEP = 0.5  # [s] of simulated time that are granted at a time on the way home
PUT_WITHIN = 5.0  # [s]

log = logging.getLogger(__name__)


@asynccontextmanager
async def left_in_order(lab: Lab, nodes: Mapping[str, SimulatorNode | RobotNode]) -> AsyncIterator[None]:
    """Do after the block, however it ends, what the lab says of its robots.

    Args:
        lab: The lab.
        nodes: Where the robots of the run live, by their names in the lab.
    """
    try:
        yield
    finally:
        with anyio.CancelScope(shield=True):
            for robot, node in nodes.items():
                after = lab.robots[robot].after
                if after is not None:
                    await _leave(robot, lab.called(robot), node, after)


async def _leave(robot: str, called: str, node: SimulatorNode | RobotNode, after: AfterFile) -> None:
    """Leave one robot in order; what goes wrong is said, and does not change how the run has ended."""
    try:
        if after.home is not None:
            await _drive_home(called, node, after.home, after.within)
        elif after.place is not None and isinstance(node, SimulatorNode):
            with anyio.fail_after(PUT_WITHIN):
                await node.set_entity_state(called, _pose(after.place), Velocity6D())
        else:
            log.warning("the robot '%s' cannot be put anywhere: it is no simulated one", robot)
    except (BackendError, TimeoutError) as error:
        log.warning("the robot '%s' was not brought back after the run: %s", robot, error or "it takes too long")


async def _drive_home(robot: str, node: SimulatorNode | RobotNode, home: PlaceFile, within: float) -> None:
    told: list[Report] = []
    over = anyio.Event()

    def tell(report: Report) -> None:
        told.append(report)
        over.set()

    goal = await node.navigate(robot, [_pose(home)], stop_at_each=False, report=tell)
    try:
        with anyio.fail_after(within):
            if isinstance(node, SimulatorNode):
                await _grant(node, over, within)
            else:
                await over.wait()
    except TimeoutError:
        await node.cancel_goal(goal)
        raise
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
