"""Commands of velocity: repeated while they hold, then zero, and nothing that outlives its deadline."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from typing import Any

import anyio

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.robots.link import FOUND_WITHIN, Link
from seoro.bridges.ros2.robots.outlet import Outlet
from seoro.bridges.ros2.robots.profile import Limits
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite
from seoro.changes import Changes

PERIOD = 0.05  # [s] between two commands
DEADLINE = 0.5  # [s] that a single command of velocity holds
STOPPING = 0.5  # [s] for which zero is repeated, so that it also ends what others have commanded meanwhile
TYPES = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
TOLERANCE = 1e-9  # of limits, for what was rounded on the way

log = logging.getLogger(__name__)


class Velocity:
    """The commands of velocity of a robot.

    Args:
        link: To the robot.
        topic: Of the commands.
        limits: That they are held to.
        note: Told why nothing can be commanded when others on the topic are in the way.
    """

    def __init__(self, link: Link, topic: str, limits: Limits, note: Callable[[str], None] = log.warning) -> None:
        self._outlet = Outlet(link, topic, self._taken_type, note)
        self._graph = link.node.graph
        self._limits = limits
        self._standstills = link.standstills
        self._number = 0  # of those when it was commanded
        self._wanted = Changes()
        self._linear = self._angular = 0.0
        self._until = 0.0  # by the machine's clock [s]

    async def find(self) -> None:
        """Be ready to command as soon as somebody subscribes, by the type that they have; does not end."""
        await self._outlet.run()

    async def check(self, linear: float, angular: float) -> None:
        """Check that a velocity [m/s, rad/s] can be commanded; waits a while for somebody who takes commands.

        Raises:
            RequestRefused: It is too fast, or nobody takes commands.
        """
        check_finite("velocity", linear, angular)
        limits = self._limits
        if abs(linear) > limits.linear + TOLERANCE or abs(angular) > limits.angular + TOLERANCE:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"{linear:g} m/s and {angular:g} rad/s are beyond the limits of the robot's profile, "
                f"{limits.linear:g} m/s and {limits.angular:g} rad/s",
            )
        outlet, graph = self._outlet, self._graph
        with anyio.move_on_after(FOUND_WITHIN):
            await graph.wait_for(self._taken_type)
            await outlet.wait()
        if outlet.publication is None or self._taken_type(graph) is None:
            silent = f"nobody on the robot subscribes to {outlet.topic}: its base does not run"
            raise RequestRefused(Result.INCORRECT_STATE, outlet.problem or silent)

    @property
    def _moves(self) -> bool:
        """Whether what is commanded is not zero."""
        return bool(self._linear or self._angular)

    def command(self, linear: float, angular: float, duration: float) -> None:
        """Command a velocity [m/s, rad/s] for a duration [s], or until the next command; it was checked before."""
        self._linear, self._angular = linear, angular
        self._until = time.monotonic() + duration
        self._number = self._standstills.number
        self._publish()
        self._wanted.tell()

    def stop(self) -> None:
        """Command zero, for a while."""
        self.command(0.0, 0.0, STOPPING)

    async def run(self) -> None:
        """Repeat what is commanded; runs as long as the bridge."""
        while True:
            await self._wanted.wait_for(lambda: time.monotonic() < self._until)
            await self._repeat()
            if self._moves:
                self.stop()

    async def end(self) -> None:
        """Command zero for a while when `run` runs no more."""
        self.stop()
        await self._repeat()

    async def _repeat(self) -> None:
        """Repeat what is commanded until its deadline."""
        while (left := self._until - time.monotonic()) > 0.0:
            await anyio.sleep(min(PERIOD, left))
            if self._moves and self._standstills.number != self._number:
                self.stop()
            elif time.monotonic() < self._until:
                self._publish()

    def _publish(self) -> None:
        publication = self._outlet.publication
        if publication is None:
            return
        twist = {"linear": {"x": self._linear}, "angular": {"z": self._angular}}
        # A stamp of zero is the time of arrival to those who look at it: clocks of robots may be off.
        message: Mapping[str, Any] = twist if publication.type == TYPES[0] else {"twist": twist}
        publication.publish(message)

    def _taken_type(self, graph: RosGraph) -> str | None:
        """The type in which commands are taken, preferably as they were given so far; None if nobody takes any."""
        types = {each.type for each in graph.subscriptions(self._outlet.topic)}
        given = self._outlet.publication
        return next((each for each in ([given.type] if given else []) + [*TYPES] if each in types), None)
