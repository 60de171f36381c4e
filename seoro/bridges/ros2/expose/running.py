"""Exposing a simulator node: from its endpoint and that of a ROS 2 system to both, until one of them is gone."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.launch import find_simulator
from seoro.bridges.ros2.expose import messages
from seoro.bridges.ros2.expose.node import ExposedNode, following
from seoro.bridges.ros2.expose.robot import ExposedRobot, RobotTopics, exposing_robot
from seoro.bridges.ros2.expose.simulation import serving_simulation
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosSystem, open_system
from seoro.bridges.ros2.silent_peers import announce_silent_peers
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.seals import node_seals
from seoro.bridges.secured import node_keys, security_of
from seoro.bridges.session import Mailbox, SessionError, open_session
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.wire.keys import NAMESPACE
from seoro.errors import BackendRefused, InvalidUse
from seoro.keys.roles import MOVING

log = logging.getLogger(__name__)

NODE = "seoro_simulator"
HELP = (
    "start a simulator with `seoro sim mujoco`, and a router with `ros2 run rmw_zenoh_cpp rmw_zenohd`, or be the "
    "router with `--ros-listen`"
)


@dataclass(frozen=True)
class ExposeSettings:
    """What is exposed where.

    Attributes:
        simulator: Zenoh endpoint of the simulator node.
        router: Zenoh endpoint of the router of the ROS 2 system; None to be the router.
        listen: Endpoint to be the router on, if there is none to connect to.
        domain: ROS_DOMAIN_ID.
        root: The robot that has its topics without a namespace, as if it were alone; empty for none.
        stamped: Whether commands of velocity are `TwistStamped`.
        navigation: Whether robots find their way by themselves; without, that is left to others, such as Nav2.
    """

    simulator: str
    router: str | None = None
    listen: str | None = None
    domain: int = 0
    root: str = ""
    stamped: bool = False
    navigation: bool = True


async def expose(settings: ExposeSettings, ready: Callable[[wire.SimulatorFeatures], None]) -> None:
    """Expose a simulator node, for ever.

    Args:
        settings: What, and where.
        ready: Called when all is announced.

    Raises:
        InvalidUse: There is no simulator node or no router, or no robot of the name that was given.
        BackendRefused: The simulator node says no to what exposing its world needs.
        BackendLost: The simulator node is gone.
    """
    keys = node_keys(settings.simulator, MOVING)
    security = security_of(settings.simulator, keys)
    listens = settings.listen is not None
    try:
        async with (
            open_session(connect=settings.simulator, security=security) as near,
            open_session(connect=settings.router, listen=settings.listen, gossip=listens) as far,
            open_system(far, TypeStore.bundled(), dialect=RmwZenoh(settings.domain)) as system,
        ):
            name = await find_simulator(near, settings.simulator)
            address = NodeAddress(near, NAMESPACE, name, seals=node_seals(near, name, keys))
            await address.prove()
            async with following(address) as node, background() as tasks:
                if listens:
                    tasks.start_soon(announce_silent_peers, far)
                await _expose(node, system, settings, ready)
    except SessionError as error:
        raise InvalidUse(str(error), help=HELP) from error
    except ExceptionGroup as group:
        raise _first(group) from None


def _first(error: Exception) -> Exception:
    return _first(error.exceptions[0]) if isinstance(error, ExceptionGroup) else error


async def _expose(
    node: ExposedNode, system: RosSystem, settings: ExposeSettings, ready: Callable[[wire.SimulatorFeatures], None]
) -> None:
    async with (
        system.node(NODE) as ros,
        ros.publishing("/clock", "rosgraph_msgs/msg/Clock") as clock,
        serving_simulation(ros, node),
    ):
        begun = False
        while True:
            order = node.worlds.order
            features = await node.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
            _look_for_root(features, settings.root, begun=begun)
            begun = True
            try:
                async with _world(node, system, settings, features, clock):
                    ready(features)
                    await node.worlds.be_exposed(order, features.world_number)
            except BackendRefused:
                if not await _has_another_world(node, features):
                    raise


def _look_for_root(features: wire.SimulatorFeatures, root: str, *, begun: bool) -> None:
    """Say that the robot is not there that is to have no namespace; a later world may lack it."""
    names = [robot.name for robot in features.robots]
    if not root or root in names:
        return
    known = f"robots of {features.world or 'no world'}: {', '.join(names) or 'none'}"
    if not begun:
        raise InvalidUse(f"there is no robot '{root}'", help=known)
    log.warning("no robot has topics without a namespace: there is no '%s'; %s", root, known)


@asynccontextmanager
async def _world(
    node: ExposedNode,
    system: RosSystem,
    settings: ExposeSettings,
    features: wire.SimulatorFeatures,
    clock: Publication,
) -> AsyncIterator[None]:
    """Expose the robots of the world that is loaded, for as long as the block lasts."""
    names = [robot.name for robot in features.robots]
    async with AsyncExitStack() as stack:
        robots: dict[str, RobotTopics] = {}
        wanted = wire.OpenStream(id="")
        for name in names:
            description = await node.ask(wire.GET_ROBOT_DESCRIPTION, wire.RobotName(robot=name))
            robot = ExposedRobot(name, description, settings.stamped, settings.navigation)
            namespace = "/" if name == settings.root else f"/{name}"
            ros = await stack.enter_async_context(system.node(f"seoro_{name}", namespace))
            robots[name] = await stack.enter_async_context(exposing_robot(ros, node, robot))
            wanted = _joined(wanted, robot.wanted)
        if features.state is not wire.SimulationState.NO_WORLD:
            told = await stack.enter_async_context(node.streaming(wanted))
            tasks = await stack.enter_async_context(background())
            tasks.start_soon(_pass_on, told, clock, robots)
        yield


def _joined(one: wire.OpenStream, other: wire.OpenStream) -> wire.OpenStream:
    return wire.OpenStream(
        id="",
        sensors=one.sensors + other.sensors,
        poses=one.poses + other.poses,
        joints=one.joints + other.joints,
        batteries=one.batteries + other.batteries,
    )


async def _has_another_world(node: ExposedNode, before: wire.SimulatorFeatures) -> bool:
    now = await node.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    return (now.world_number, now.world, now.robots) != (before.world_number, before.world, before.robots)


async def _pass_on(stream: Mailbox[wire.Streamed], clock: Publication, robots: Mapping[str, RobotTopics]) -> None:
    """Publish what the simulator node publishes."""
    async for told in stream:
        clock.publish(messages.clock(told.time))
        for each in told.samples:
            robots[each.robot].publish_sample(each.sample)
        for pose in told.poses:
            robots[pose.robot].publish_pose(pose, told.time)
        for joints in told.joints:
            robots[joints.robot].publish_joints(joints.joints, told.time)
        for battery in told.batteries:
            robots[battery.robot].publish_battery(battery.charge, told.time)
