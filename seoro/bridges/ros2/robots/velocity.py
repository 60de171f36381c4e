"""Velocity commands: repeated until their deadline, then zero."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from typing import Any

import anyio

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.robots.lazy_publisher import LazyPublisher
from seoro.bridges.ros2.robots.link import DISCOVERY_TIMEOUT, Link
from seoro.bridges.ros2.robots.profile import Limits
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite
from seoro.concurrency.condition import Condition

PERIOD = 0.05  # [s] between two commands
DEADLINE = 0.5  # [s] for which a single velocity command holds
STOPPING = 0.5  # [s] for which zero is repeated, to override commands of other publishers
TYPES = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
TOLERANCE = 1e-9  # tolerance of the limits, for rounding

log = logging.getLogger(__name__)


class Velocity:
    """Velocity commands to a robot.

    Args:
        link: Link to the robot.
        topic: Topic of the commands.
        limits: Limits of the commands.
        note: Called with each conflict of types on the topic.
    """

    def __init__(self, link: Link, topic: str, limits: Limits, note: Callable[[str], None] = log.warning) -> None:
        self._publisher = LazyPublisher(link, topic, self._accepted_type, note)
        self._graph = link.node.graph
        self._limits = limits
        self._standstills = link.state.standstills
        self._number = 0  # of standstills at the last command
        self._commanded = Condition()
        self._linear = self._angular = 0.0
        self._until = 0.0  # deadline, by the machine's clock [s]

    async def find(self) -> None:
        """Create the publisher when the robot subscribes, with the type of its subscription; without end."""
        await self._publisher.run()

    async def check(self, linear: float, angular: float) -> None:
        """Check that a velocity [m/s, rad/s] can be commanded; wait a while for a subscription.

        Raises:
            RequestRefused: The velocity is beyond the limits, or the robot does not subscribe to commands.
        """
        check_finite("velocity", linear, angular)
        limits = self._limits
        if abs(linear) > limits.linear + TOLERANCE or abs(angular) > limits.angular + TOLERANCE:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"{linear:g} m/s and {angular:g} rad/s are beyond the limits of the robot's profile, "
                f"{limits.linear:g} m/s and {limits.angular:g} rad/s",
            )
        if self._has_subscription:
            return
        publisher = self._publisher
        with anyio.move_on_after(DISCOVERY_TIMEOUT):
            await self._graph.wait_for(self._accepted_type)
            await publisher.wait()
        if not self._has_subscription:
            silent = f"no subscription to {publisher.topic} on the robot: its base is not running"
            raise RequestRefused(Result.INCORRECT_STATE, publisher.problem or silent)

    @property
    def _has_subscription(self) -> bool:
        """Whether commands reach a subscription."""
        return self._publisher.publication is not None and self._accepted_type(self._graph) is not None

    @property
    def _moves(self) -> bool:
        """Whether the commanded velocity is not zero."""
        return bool(self._linear or self._angular)

    def command(self, linear: float, angular: float, duration: float) -> None:
        """Command a checked velocity [m/s, rad/s] for a duration [s], or until the next command."""
        self._linear, self._angular = linear, angular
        self._until = time.monotonic() + duration
        self._number = self._standstills.number
        self._publish()
        self._commanded.notify_all()

    def stop(self) -> None:
        """Command zero for a while."""
        self.command(0.0, 0.0, STOPPING)

    async def run(self) -> None:
        """Repeat the commands, without end."""
        while True:
            await self._commanded.wait_for(lambda: time.monotonic() < self._until)
            await self._repeat()
            if self._moves:
                self.stop()

    async def end(self) -> None:
        """Command zero for a while, after the end of `run`."""
        self.stop()
        await self._repeat()

    async def _repeat(self) -> None:
        """Repeat the command until its deadline."""
        while (left := self._until - time.monotonic()) > 0.0:
            await anyio.sleep(min(PERIOD, left))
            if self._moves and self._standstills.number != self._number:
                self.stop()
            elif time.monotonic() < self._until:
                self._publish()

    def _publish(self) -> None:
        publication = self._publisher.publication
        if publication is None:
            return
        twist = {"linear": {"x": self._linear}, "angular": {"z": self._angular}}
        # Robots replace a stamp of zero by the time of arrival; their clocks may differ from that of this machine.
        message: Mapping[str, Any] = twist if publication.type == TYPES[0] else {"twist": twist}
        publication.publish(message)

    def _accepted_type(self, graph: RosGraph) -> str | None:
        """Return the type that subscriptions accept, preferably the present one; None without subscriptions."""
        types = {each.type for each in graph.subscriptions(self._publisher.topic)}
        present = self._publisher.publication
        return next((each for each in ([present.type] if present else []) + [*TYPES] if each in types), None)
