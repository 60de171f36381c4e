"""Bridge between the robots of a ROS 2 system and a node of seoro."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import anyio

from seoro.bridges.ros2.clock import SharedClock
from seoro.bridges.ros2.participant import BRIDGE, GUARD, RosOptions, RosSystem, connect_system
from seoro.bridges.ros2.robots.guard import GuardSettings
from seoro.bridges.ros2.robots.guard_state import STOOD_STILL, Standstills
from seoro.bridges.ros2.robots.guarded import guarded
from seoro.bridges.ros2.robots.link import RobotLink
from seoro.bridges.ros2.robots.profile import BridgedRobot
from seoro.bridges.ros2.robots.robot import RosRobot
from seoro.bridges.ros2.wire.names import resolve
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.node import RobotServer, serving
from seoro.bridges.serving.work import Work
from seoro.concurrency.background import background
from seoro.security.network.listener import node_listener

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class BridgeOptions:
    """Options of a bridge.

    Args:
        robots: The robots.
        ros: Options of the connection to the ROS 2 system.
        node: Name of the bridge, for runs.
        listen: Zenoh endpoint to listen on for runs; alternative to `connect`.
        connect: Zenoh endpoint of a router for runs.
        state: File that keeps an emergency stop after the end of the bridge, if any.
        log: Log file of the requests to a bridge with keys.
    """

    robots: Sequence[BridgedRobot]
    ros: RosOptions
    node: str = "ros2"
    listen: str | None = None
    connect: str | None = None
    state: Path | None = None
    log: Path | None = None


@asynccontextmanager
async def bridging(options: BridgeOptions) -> AsyncIterator[None]:
    """Serve robots of a ROS 2 system to runs during the block; afterwards the robots stand still.

    Raises:
        UsageError: The keys of the bridge are missing or not needed, or the system uses both dialects.
        SessionError: An endpoint does not work.
        BackendError: The ROS 2 system was not found, or the guard of the bridge does not start.
    """
    listener = node_listener(options.listen, options.connect, options.node)
    async with connect_system(options.ros) as system:
        warn_if_shared(options.robots, system)
        ros = replace(options.ros, dialect=system.dialect.name, interfaces=())
        settings = GuardSettings(ros=ros, session=system.session.identity, robots=tuple(options.robots))
        robots: list[RosRobot] = []
        async with (
            guarded(settings) as state,
            AsyncExitStack() as stack,
            _stopping_at_end(robots),
            background() as tasks,
        ):
            namespaces = [robot.namespace for robot in options.robots]
            nodes = [await stack.enter_async_context(system.node(BRIDGE, each)) for each in namespaces]

            def make(work: Work, events: EventLog) -> Sequence[RosRobot]:
                for robot, node in zip(options.robots, nodes, strict=True):
                    link = RobotLink(node, stack, tasks, state, name=robot.name, work=work, events=events)
                    robots.append(RosRobot(robot.profile, link))
                return robots

            def forget() -> None:
                for robot in robots:
                    robot.forget()

            async with (
                serving(listener, options.node, make, options.state, options.log, state.set_stopping) as server,
                system.node(BRIDGE) as node,
                SharedClock(node, tasks).using(log.warning, forget),
            ):
                for robot in robots:
                    await robot.open()
                tasks.start_soon(_stop_after_standstills, state.standstills, server)
                yield


async def _stop_after_standstills(standstills: Standstills, server: RobotServer) -> None:
    """Stop all goals after each standstill, in which the guard has stopped the robots, without end."""
    over = asyncio.Event()
    standstills.on_standstill = partial(asyncio.get_running_loop().call_soon_threadsafe, over.set)
    while True:
        await over.wait()
        over.clear()
        log.warning("%s: the robots are stopped, and their goals have failed", STOOD_STILL)
        await server.stop(STOOD_STILL)


@asynccontextmanager
async def _stopping_at_end(robots: Sequence[RosRobot]) -> AsyncIterator[None]:
    """Command zero velocity to the robots for a while after the block."""
    try:
        yield
    finally:
        with anyio.CancelScope(shield=True):
            async with anyio.create_task_group() as tasks:
                for robot in robots:
                    tasks.start_soon(robot.end)


def warn_if_shared(robots: Sequence[BridgedRobot], system: RosSystem) -> None:
    """Warn if another bridge serves a robot; both would command it.

    Must be called before this bridge has a guard. The guard of another bridge follows the goals of its own robots,
    which may share `tf` with other robots, and may run for a while after its bridge.
    """

    def is_followed(robot: BridgedRobot, topic: str, by: str) -> bool:
        followers = system.graph.subscriptions(resolve(topic, robot.namespace, by))
        return any(each.node is not None and each.node.name == by for each in followers)

    for robot in robots:
        statuses = [f"{action}/_action/status" for action in robot.profile.actions]
        is_guarded = any(is_followed(robot, each, GUARD) for each in statuses)
        if is_guarded and is_followed(robot, robot.profile.tf, BRIDGE):
            log.warning(
                "another bridge serves a robot in the namespace %s, too: runs over both would command '%s' at the "
                "same time; end one of them",
                robot.namespace,
                robot.name,
            )
