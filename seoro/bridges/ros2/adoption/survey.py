"""Survey of a found robot: a message of its topics, parameters of its nodes, and its description."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Final

import anyio

from seoro.bridges.ros2.adoption.finding import FoundRobot, find_robots
from seoro.bridges.ros2.clients.parameters import get_parameters, list_parameters
from seoro.bridges.ros2.descriptions import decode_message
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.tf.listener import listen
from seoro.bridges.ros2.urdf import Links, read_links
from seoro.bridges.ros2.wire import Endpoint
from seoro.bridges.ros2.wire.qos import matching_qos
from seoro.concurrency.gathering import gather
from seoro.errors import BackendError, UsageError

START_TIMEOUT: Final = 5.0  # [s] for nodes to start
SETTLED_AFTER: Final = 1.0  # [s] without changes
MESSAGE_TIMEOUT: Final = 5.0  # [s]
FRAMES_TIME: Final = 1.0  # [s] in which frames are collected
PARAMETER_TIMEOUT: Final = 3.0  # [s] for all parameters of a node
SAMPLED: Final = ("odometry", "joint_states", "camera", "lidar", "battery", "description", "semantics")
NAVIGATION_NODES: Final = ("velocity_smoother", "controller_server", "bt_navigator", "amcl")

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Survey:
    """Messages, parameters and description of a robot.

    Attributes:
        robot: Its endpoints.
        messages: First message of each topic, by full name; topics without a message are left out.
        parameters: Values of parameters, by the full name of the node.
        links: Joints of its description; None without a readable one.
        parents: Parent of each frame.
    """

    robot: FoundRobot
    messages: Mapping[str, Message] = field(default_factory=dict)
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    links: Links | None = None
    parents: Mapping[str, str] = field(default_factory=dict)

    def message(self, part: str) -> Message | None:
        """Return the message of the likeliest topic of a part."""
        return self.messages.get(self.robot.name(part)) if part in self.robot else None

    def parameters_of(self, part: str) -> Mapping[str, Any]:
        """Return the parameters of the node of a part."""
        node = self.robot.parts[part][0].node if part in self.robot else None
        return {} if node is None else self.parameters.get(node.full_name, {})

    def parameters_named(self, name: str) -> Mapping[str, Any]:
        """Return the parameters of the first node with a name in any namespace."""
        return next((each for node, each in self.parameters.items() if node.rpartition("/")[2] == name), {})


async def wait_for_robots(node: RosNode) -> tuple[FoundRobot, ...]:
    """Return the robots of a system; wait a while for the first one, and for nodes that are starting."""
    graph, own = node.graph, node.node.session

    before: frozenset[Endpoint] = frozenset()

    def has_changed(seen: RosGraph) -> bool:
        return frozenset(node.others(seen.endpoints())) != before

    with anyio.move_on_after(START_TIMEOUT), suppress(TimeoutError):
        await graph.wait_for(lambda seen: find_robots(seen, own))
        while True:
            before = frozenset(node.others(graph.endpoints()))
            await graph.wait_for(has_changed, SETTLED_AFTER)
    return find_robots(graph, own)


async def survey(node: RosNode, robot: FoundRobot) -> Survey:
    """Read messages and parameters of a robot, for a few seconds.

    Args:
        node: Own node.
        robot: The robot.
    """
    topics = sorted({(each.name, each.type) for part in SAMPLED for each in robot.parts.get(part, ())})
    owners = sorted({*robot.nodes, *_navigation_nodes(node.graph, robot)})
    messages: dict[str, Message] = {}
    parameters: dict[str, Mapping[str, Any]] = {}

    async def sample(topic: tuple[str, str]) -> None:
        message = await _first_message(node, *topic)
        if message is not None:
            messages[topic[0]] = message

    async def inquire(owner: str) -> None:
        found = await _parameters(node, owner)
        if found:
            parameters[owner] = found

    namespace = robot.name("tf").rpartition("/")[0] if "tf" in robot else ""
    async with listen(node, namespace) as listener, anyio.create_task_group() as tasks:
        tasks.start_soon(gather, sample, topics)
        tasks.start_soon(gather, inquire, owners)
        await anyio.sleep(FRAMES_TIME)
    parents = dict(listener.buffer.parents)
    text = messages.get(robot.name("description")) if "description" in robot else None
    return Survey(robot, messages, parameters, None if text is None else _links(text.data), parents)


def _navigation_nodes(graph: RosGraph, robot: FoundRobot) -> list[str]:
    """Return the nodes of Nav2 in the namespace of a robot."""
    prefix = robot.namespace.rstrip("/")
    return [name for each in NAVIGATION_NODES if (name := f"{prefix}/{each}") in graph.nodes()]


async def _first_message(node: RosNode, topic: str, type_name: str) -> Message | None:
    offered = [each.qos for each in node.graph.publishers(topic) if each.qos is not None]
    try:
        with anyio.move_on_after(MESSAGE_TIMEOUT):
            async with node.subscribing(topic, type_name, matching_qos(offered), is_checked=False) as subscription:
                return await decode_message(node, subscription, await subscription.receive())
    except (BackendError, UsageError) as error:
        log.warning("no message of %s: %s", topic, error)
    return None


async def _parameters(node: RosNode, owner: str) -> Mapping[str, Any]:
    """Return the parameters of a node that have a value; none if it does not answer."""
    if not node.graph.servers(f"{owner}/list_parameters"):
        return {}
    try:
        with anyio.move_on_after(PARAMETER_TIMEOUT):
            values = await get_parameters(node, owner, await list_parameters(node, owner))
            return {name: value for name, value in values.items() if value is not None}
    except BackendError as error:
        log.warning("no parameters of %s: %s", owner, error)
    return {}


def _links(urdf: str) -> Links | None:
    try:
        return read_links(urdf)
    except ValueError as error:
        log.warning("unreadable robot_description: %s", error)
        return None
