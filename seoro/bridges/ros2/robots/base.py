"""A base that drives: velocities, odometry, and watches on where it is."""

from __future__ import annotations

import math
from functools import partial

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.frames import Frames
from seoro.bridges.ros2.robots.link import FOUND_WITHIN, Link
from seoro.bridges.ros2.robots.localisation import Localisation
from seoro.bridges.ros2.robots.navigation import Navigation
from seoro.bridges.ros2.robots.profile import Base
from seoro.bridges.ros2.robots.velocity import DEADLINE, Velocity
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.serving.work import Work
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_drive_duration, check_finite, check_positive, listed
from seoro.changes import Changes

SEEN_WITHIN = 1.0  # [s] that a frame may take to appear, such as `map` once the robot knows where it is
LEAP = 1.0  # [m] between two messages of odometry, beyond which it has started over


class DrivingBase:
    """The base of a robot.

    Args:
        link: To the robot.
        base: What it calls things.
        frames: Where its frames are.
        robot: Its name.
        work: Where goals and watches run.
        happenings: Where it is told how far it is on its way.
    """

    def __init__(
        self, link: Link, base: Base, frames: Frames, robot: str, work: Work, happenings: HappeningLog
    ) -> None:
        self._link = link
        self._base = base
        self._frames = frames
        self._robot = robot
        self._work = work
        self._velocity = Velocity(link, base.cmd_vel, base.limits)
        self._localisation = Localisation(link, base, work)
        self._navigation = Navigation(link, base, robot, work, happenings)
        self._place: tuple[float, float] | None = None
        self._travelled = 0.0  # [m]
        self._moved = Changes()
        self._was_driven = False  # by this bridge

    @property
    def handlers(self) -> Handlers:
        """The verbs that it serves."""
        return {
            **self._localisation.handlers,
            wire.NAVIGATE_THROUGH_POSES: self._navigate,
            wire.DRIVE: self._drive,
            wire.CMD_VEL: self._cmd_vel,
            wire.WATCH_PROXIMITY: self._watch_proximity,
            wire.WATCH_DISTANCE: self._watch_distance,
        }

    @property
    def localisation(self) -> Localisation:
        """Where it believes to be."""
        return self._localisation

    async def open(self) -> None:
        """Listen to the robot, and be ready to command it."""
        await self._link.listen(self._base.odometry, "nav_msgs/msg/Odometry", self._take_odometry)
        await self._localisation.open()
        self._link.tasks.start_soon(self._velocity.find)
        self._link.tasks.start_soon(self._velocity.run)

    def stop(self) -> None:
        """Command zero velocity."""
        self._velocity.stop()

    async def end(self) -> None:
        """Command zero velocity for a while, if the base was ever driven; nothing else of it runs any more."""
        if self._was_driven:
            await self._velocity.end()

    def forget(self) -> None:
        """Forget where the robot was; the way that it has gone is counted on from where it is next."""
        self._place = None

    def _take_odometry(self, message: Message) -> None:
        place = message.pose.pose.position
        if self._place is not None:
            step = math.dist((place.x, place.y), self._place)
            self._travelled += step if step < LEAP else 0.0
        self._place = (place.x, place.y)
        self._moved.tell()

    async def _navigate(self, request: wire.NavigateThroughPoses) -> wire.Empty:
        self._was_driven = True
        return await self._navigation.navigate(request)

    async def _drive(self, request: wire.Drive) -> wire.Empty:
        check_drive_duration(request.duration)
        await self._velocity.check(request.linear, request.angular)
        self._was_driven = True

        async def drive() -> str:
            number = self._link.standstills.number
            try:
                self._velocity.command(request.linear, request.angular, request.duration)
                await anyio.sleep(request.duration)
                self._link.standstills.check(number)
            finally:
                self._velocity.stop()
            return ""

        self._work.start(request.id, drive, robot=self._robot)
        return wire.Empty()

    async def _cmd_vel(self, request: wire.CmdVel) -> wire.Empty:
        linear, angular = request.twist.linear, request.twist.angular
        if any((linear.y, linear.z, angular.x, angular.y)):
            raise RequestRefused(
                Result.OPERATION_FAILED,
                "the robot drives along its x axis and turns about z: leave the rest of the twist at 0",
            )
        await self._velocity.check(linear.x, angular.z)
        self._work.check_free(self._robot)
        self._was_driven = True
        self._velocity.command(linear.x, angular.z, DEADLINE)
        return wire.Empty()

    async def _watch_proximity(self, request: wire.WatchProximity) -> wire.Empty:
        check_finite("point", request.point.x, request.point.y)
        check_positive("threshold", request.threshold)
        wanted = {request.frame, request.parent_frame}
        with anyio.move_on_after(SEEN_WITHIN):
            await self._frames.changes.wait_for(lambda: wanted <= self._frames.names)
        missing = wanted - self._frames.names
        if missing:
            raise RequestRefused(
                Result.NOT_FOUND,
                f"there is no frame {listed(missing)}: the robot '{self._robot}' has {listed(self._frames.names)}",
            )
        self._work.start(request.id, partial(self._come_near, request))
        return wire.Empty()

    async def _come_near(self, request: wire.WatchProximity) -> str:
        def is_near() -> bool:
            point = request.point
            away = self._frames.distance(request.frame, request.parent_frame, point.x, point.y)
            return away <= request.threshold

        await self._frames.changes.wait_for(is_near)
        return ""

    async def _watch_distance(self, request: wire.WatchDistance) -> wire.Empty:
        check_positive("distance", request.distance)
        with anyio.move_on_after(FOUND_WITHIN):
            await self._moved.wait_for(lambda: self._place is not None)
        if self._place is None:
            topic = self._link.node.resolve(self._base.odometry)
            why = self._link.why_silent(topic)
            raise RequestRefused(Result.INCORRECT_STATE, f"the robot says nothing on {topic}, its odometry: {why}")
        target = self._travelled + request.distance

        async def travel() -> str:
            await self._moved.wait_for(lambda: self._travelled >= target)
            return ""

        self._work.start(request.id, travel)
        return wire.Empty()
