"""The bridge: robots of a ROS 2 system on one side, a node of seoro on the other."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio
from anyio.abc import TaskGroup

from seoro.background import background
from seoro.bridges.door import Door, node_door
from seoro.bridges.ros2.clock import SharedClock
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.own_nodes import BRIDGE, GUARD
from seoro.bridges.ros2.participant import RosSystem, connect
from seoro.bridges.ros2.robots.alarm import Alarm
from seoro.bridges.ros2.robots.guard import PERIOD, GuardedRobot, GuardSettings
from seoro.bridges.ros2.robots.guarded import guarded
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.profile import Profile
from seoro.bridges.ros2.robots.robot import RosRobot
from seoro.bridges.ros2.robots.standstill import STOOD_STILL, Standstills
from seoro.bridges.ros2.robots.unanswered import Unanswered
from seoro.bridges.ros2.wire import RmwZenoh, named_dialect
from seoro.bridges.ros2.wire.names import resolve
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.node import RobotServer, serving
from seoro.bridges.serving.work import Work

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class BridgedRobot:
    """A robot to bridge: its name for scenarios, its profile, and its namespace in ROS 2."""

    name: str
    profile: Profile
    namespace: str = "/"


@dataclass(frozen=True)
class BridgeOptions:
    """A bridge.

    Args:
        robots: The robots.
        ros: Zenoh endpoint of the router of the ROS 2 system, or of its bridge for DDS.
        domain: ROS_DOMAIN_ID.
        interfaces: Folders with definitions of messages that seoro does not bring.
        node: Name of the bridge, for runs.
        listen: Zenoh endpoint to listen on for runs; or `connect`.
        connect: Zenoh endpoint of a router to be reached over.
        state: File in which an emergency stop outlasts the bridge; None for nowhere.
        log: File of the log of what is asked of a bridge with keys.
        dialect: `rmw_zenoh` or `ros2dds`; found out when None.
    """

    robots: Sequence[BridgedRobot]
    ros: str
    domain: int = 0
    interfaces: Sequence[Path] = ()
    node: str = "ros2"
    listen: str | None = None
    connect: str | None = None
    state: Path | None = None
    log: Path | None = None
    dialect: str | None = None


@asynccontextmanager
async def bridging(options: BridgeOptions) -> AsyncIterator[None]:
    """Serve robots of a ROS 2 system to runs for as long as the block lasts; then they stand still.

    Raises:
        InvalidUse: Its keys are missing, or of no use there; or the system speaks both dialects.
        SessionError: An endpoint does not work.
        BackendError: There is no ROS 2 system, or the guard of the bridge does not start.
    """
    types = TypeStore.bundled()
    for folder in options.interfaces:
        types = types.add_folder(folder)
    dialect = named_dialect(options.dialect, options.domain)
    unanswered, alarm = Unanswered(), Alarm()
    door = node_door(options.listen, options.connect, options.node)
    async with connect(options.ros, types=types, dialect=dialect, domain=options.domain) as system:
        warn_of_others(options.robots, system)
        async with (
            guarded(_guard_of(options, system), unanswered, alarm) as standstills,
            _served(options, door, system, standstills, unanswered, alarm),
        ):
            yield


@asynccontextmanager
async def _served(
    options: BridgeOptions,
    door: Door,
    system: RosSystem,
    standstills: Standstills,
    unanswered: Unanswered,
    alarm: Alarm,
) -> AsyncIterator[None]:
    """Be between the robots and runs, in a bridge that has a guard."""
    made: list[RosRobot] = []
    async with (
        AsyncExitStack() as stack,
        _at_rest(made),
        background() as tasks,
    ):
        links = [await _link(system, each, stack, tasks, standstills, unanswered) for each in options.robots]

        def make(work: Work, happenings: HappeningLog) -> Sequence[RosRobot]:
            made.extend(
                RosRobot(robot.name, robot.profile, link, work, happenings)
                for robot, link in zip(options.robots, links, strict=True)
            )
            return made

        def forget() -> None:
            for robot in made:
                robot.forget()

        async with (
            serving(door, options.node, make, options.state, options.log, alarm.set) as server,
            system.node(BRIDGE) as node,
            SharedClock(node, tasks).used(log.warning, forget),
        ):
            for robot in made:
                await robot.open()
            tasks.start_soon(_stop_after_standstills, standstills, server)
            yield


async def _stop_after_standstills(standstills: Standstills, server: RobotServer) -> None:
    """End what was under way whenever the bridge stood still, and its guard stopped the robots; without end."""
    seen = standstills.number
    while True:
        await anyio.sleep(PERIOD)
        if seen != (seen := standstills.number):
            log.warning("%s: the robots are stopped, and their goals have failed", STOOD_STILL)
            await server.stop(STOOD_STILL)


@asynccontextmanager
async def _at_rest(robots: Sequence[RosRobot]) -> AsyncIterator[None]:
    """Keep robots at zero velocity for a while after the block, whose tasks repeat nothing any more."""
    try:
        yield
    finally:
        with anyio.CancelScope(shield=True):
            async with anyio.create_task_group() as tasks:
                for robot in robots:
                    tasks.start_soon(robot.end)


def warn_of_others(robots: Sequence[BridgedRobot], system: RosSystem) -> None:
    """Say that another bridge serves a robot already: its runs and ours would command it at the same time.

    To be called before this one has a guard. That of another follows the goals of its robots and no others', which
    may share `tf`; it may be there for a while after its bridge.
    """

    def is_followed(robot: BridgedRobot, topic: str, by: str) -> bool:
        followers = system.graph.subscriptions(resolve(topic, robot.namespace, by))
        return any(each.node is not None and each.node.name == by for each in followers)

    for robot in robots:
        statuses = [f"{action}/_action/status" for action in robot.profile.actions]
        is_guarded = any(is_followed(robot, each, GUARD) for each in statuses)
        if is_guarded and is_followed(robot, robot.profile.tf, BRIDGE):
            log.warning(
                "another bridge serves a robot in the namespace %s, too: runs over either would command '%s' at "
                "the same time; end one of them",
                robot.namespace,
                robot.name,
            )


def _guard_of(options: BridgeOptions, system: RosSystem) -> GuardSettings:
    robots = [
        GuardedRobot(
            name=robot.name,
            namespace=robot.namespace,
            cmd_vel="" if robot.profile.base is None else robot.profile.base.cmd_vel,
            limits=None if robot.profile.base is None else robot.profile.base.limits,
            actions=robot.profile.actions,
        )
        for robot in options.robots
    ]
    return GuardSettings(
        ros=options.ros,
        domain=options.domain,
        is_rmw_zenoh=isinstance(system.dialect, RmwZenoh),
        session=system.session.identity,
        robots=tuple(robots),
    )


async def _link(
    system: RosSystem,
    robot: BridgedRobot,
    stack: AsyncExitStack,
    tasks: TaskGroup,
    standstills: Standstills,
    unanswered: Unanswered,
) -> Link:
    node = await stack.enter_async_context(system.node(BRIDGE, robot.namespace))
    return Link(node, stack, tasks, standstills, unanswered)
