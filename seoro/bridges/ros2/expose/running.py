"""Exposure of a simulator node as a ROS 2 system, from the endpoints of both."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

from seoro.bridges import wire
from seoro.bridges.launch import find_simulator
from seoro.bridges.ros2.expose import messages
from seoro.bridges.ros2.expose.node import ExposedNode, following_node
from seoro.bridges.ros2.expose.robot import ExposedRobot, RobotTopics, exposing_robot, stream_of
from seoro.bridges.ros2.expose.sensors import publish_on_demand
from seoro.bridges.ros2.expose.simulation import serving_simulation
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosSystem, open_system
from seoro.bridges.ros2.silent_peers import announce_silent_peers
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import Mailbox, SessionError, is_local, open_session
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.wire.keys import NAMESPACE
from seoro.concurrency.background import background
from seoro.errors import BackendRefused, UsageError, cause_of
from seoro.security.keys.roles import MOVING
from seoro.security.network.endpoint_keys import node_keys, security_of
from seoro.security.network.peers import node_signer

log = logging.getLogger(__name__)

NODE = "seoro_simulator"
HELP = (
    "start a simulator with `seoro sim mujoco`, and a router with `ros2 run rmw_zenoh_cpp rmw_zenohd` or with "
    "`--ros-listen`"
)


@dataclass(frozen=True)
class ExposeSettings:
    """Options of an exposed simulator.

    Attributes:
        simulator: Zenoh endpoint of the simulator node.
        router: Zenoh endpoint of the router of the ROS 2 system; None to run a router.
        listen: Zenoh endpoint of the router to run, if any.
        domain: ROS_DOMAIN_ID.
        root: Robot whose topics have no namespace; empty for none.
        stamped: Whether velocity commands are `TwistStamped`.
        navigation: Whether to expose the navigation of the robots; otherwise, use Nav2 for example.
    """

    simulator: str
    router: str | None = None
    listen: str | None = None
    domain: int = 0
    root: str = ""
    stamped: bool = False
    navigation: bool = True


async def expose(settings: ExposeSettings, ready: Callable[[wire.SimulatorFeatures], None]) -> None:
    """Expose a simulator node, without end.

    Args:
        settings: Options.
        ready: Called when all topics and services of a world are announced.

    Raises:
        UsageError: The simulator node, the router or the named robot is missing.
        BackendRefused: The simulator node refuses a necessary request.
        BackendLost: The simulator node has disappeared.
    """
    keys = node_keys(settings.simulator, MOVING)
    security = security_of(settings.simulator, keys)
    listens = settings.listen is not None
    is_gossiping = settings.router is None or is_local(settings.router)
    try:
        async with (
            open_session(connect=settings.simulator, security=security) as near,
            open_session(
                connect=settings.router, listen=settings.listen, patient=listens, gossip=is_gossiping
            ) as far,
            open_system(far, TypeStore.bundled(), dialect=RmwZenoh(settings.domain)) as system,
        ):
            name = await find_simulator(near, settings.simulator)
            address = NodeAddress(near, NAMESPACE, name, signer=node_signer(near, name, keys))
            await address.prove()
            async with following_node(address) as node, background() as tasks:
                if listens:
                    tasks.start_soon(announce_silent_peers, far)
                await _expose(node, system, settings, ready)
    except SessionError as error:
        raise UsageError(str(error), help=HELP) from error
    except ExceptionGroup as group:
        raise cause_of(group) from None


async def _expose(
    node: ExposedNode, system: RosSystem, settings: ExposeSettings, ready: Callable[[wire.SimulatorFeatures], None]
) -> None:
    async with (
        system.node(NODE) as ros,
        ros.publishing("/clock", "rosgraph_msgs/msg/Clock") as clock,
        serving_simulation(ros, node),
    ):
        is_first = True
        while True:
            request = node.worlds.request
            features = await node.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
            _check_root(features, settings.root, is_first=is_first)
            is_first = False
            try:
                async with _exposing_world(node, system, settings, features, clock):
                    ready(features)
                    await node.worlds.wait_replaced(request, features.world_number)
            except BackendRefused:
                if not await _has_another_world(node, features):
                    raise


def _check_root(features: wire.SimulatorFeatures, root: str, *, is_first: bool) -> None:
    """Check that the first world has the robot without a namespace; warn if a later world lacks it.

    Raises:
        UsageError: The first world lacks the robot.
    """
    names = [robot.name for robot in features.robots]
    if not root or root in names:
        return
    known = f"robots of {features.world or 'no world'}: {', '.join(names) or 'none'}"
    if is_first:
        raise UsageError(f"unknown robot '{root}'", help=known)
    log.warning("no robot has topics without a namespace: unknown robot '%s'; %s", root, known)


@asynccontextmanager
async def _exposing_world(
    node: ExposedNode,
    system: RosSystem,
    settings: ExposeSettings,
    features: wire.SimulatorFeatures,
    clock: Publication,
) -> AsyncIterator[None]:
    """Expose the robots of the present world during the block."""
    async with AsyncExitStack() as stack:
        robots: dict[str, RobotTopics] = {}
        for name in [robot.name for robot in features.robots]:
            description = await node.ask(wire.GET_ROBOT_DESCRIPTION, wire.RobotName(robot=name))
            robot = ExposedRobot(name, description, settings.stamped, settings.navigation)
            namespace = "/" if name == settings.root else f"/{name}"
            ros = await stack.enter_async_context(system.node(f"seoro_{name}", namespace))
            robots[name] = await stack.enter_async_context(exposing_robot(ros, node, robot))
        if features.state is not wire.SimulationState.NO_WORLD:
            wanted = stream_of([each.robot for each in robots.values()], node.new_id())
            updates = await stack.enter_async_context(node.streaming(wanted))
            tasks = await stack.enter_async_context(background())
            tasks.start_soon(_publish_updates, updates, clock, robots)
            sensors = [sensor for each in robots.values() for sensor in each.sensors]
            tasks.start_soon(publish_on_demand, node, system.graph, sensors)
        yield


async def _has_another_world(node: ExposedNode, before: wire.SimulatorFeatures) -> bool:
    now = await node.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    return (now.world_number, now.world, now.robots) != (before.world_number, before.world, before.robots)


async def _publish_updates(
    stream: Mailbox[wire.StreamUpdate], clock: Publication, robots: Mapping[str, RobotTopics]
) -> None:
    async for update in stream:
        clock.publish(messages.clock(update.time))
        for each in update.samples:
            robots[each.robot].publish_sample(each.sample)
        for pose in update.poses:
            robots[pose.robot].publish_pose(pose, update.time)
        for joints in update.joints:
            robots[joints.robot].publish_joints(joints.joints, update.time)
        for battery in update.batteries:
            robots[battery.robot].publish_battery(battery.charge, update.time)
