"""Driving base of a robot: velocity commands, navigation, odometry, and watches of its position."""

from __future__ import annotations

import math
from contextlib import suppress
from functools import partial

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.link import DISCOVERY_TIMEOUT, RobotLink
from seoro.bridges.ros2.robots.localisation import BASE, Localisation
from seoro.bridges.ros2.robots.navigation import navigate
from seoro.bridges.ros2.robots.profile import Base
from seoro.bridges.ros2.robots.velocity import DEADLINE, Velocity
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import (
    RequestRefused,
    check_drive_duration,
    check_finite,
    check_positive,
    name_list,
)

ODOMETRY_FRAME = "odom"
ODOMETRY = "nav_msgs/msg/Odometry"
FRAME_TIMEOUT = 1.0  # [s] for a frame to appear, such as `map` after the localisation
MAX_STEP = 1.0  # [m] between two odometry messages; a longer step means that the odometry was reset


class DrivingBase:
    """Base of a robot.

    Args:
        link: Link to the robot.
        base: Names of the topics and actions of the base.
    """

    def __init__(self, link: RobotLink, base: Base) -> None:
        self._link = link
        self._base = base
        self._velocity = Velocity(link, base.cmd_vel, base.limits)
        self.localisation = Localisation(link, base)
        self._odometry: Message | None = None
        self._travelled = 0.0  # [m]
        self._was_driven = False  # by this bridge

    @property
    def handlers(self) -> Handlers:
        """Handlers of the served verbs."""
        return {
            **self.localisation.handlers,
            wire.GET_LOCALIZATION: self._get_localization,
            wire.NAVIGATE_THROUGH_POSES: self._navigate,
            wire.DRIVE: self._drive,
            wire.CMD_VEL: self._cmd_vel,
            wire.WATCH_PROXIMITY: self._watch_proximity,
            wire.WATCH_DISTANCE: self._watch_distance,
        }

    async def open(self) -> None:
        """Subscribe to the topics of the base, and prepare velocity commands."""
        await self._link.listen(self._base.odometry, ODOMETRY, self._on_odometry)
        await self.localisation.open()
        self._link.tasks.start_soon(self._velocity.find)
        self._link.tasks.start_soon(self._velocity.run)

    def stop(self) -> None:
        """Command zero velocity."""
        self._velocity.stop()

    async def end(self) -> None:
        """Command zero velocity for a while if the base was ever driven, after all other commands."""
        if self._was_driven:
            await self._velocity.end()

    def forget(self) -> None:
        """Forget the position of the robot; the travelled distance continues from the next position."""
        self._odometry = None

    def _on_odometry(self, message: Message) -> None:
        if self._odometry is not None:
            before, now = self._odometry.pose.pose.position, message.pose.pose.position
            step = math.dist((now.x, now.y), (before.x, before.y))
            self._travelled += step if step < MAX_STEP else 0.0
        self._odometry = message

    async def _get_localization(self, _request: wire.RobotName) -> wire.Localization:
        """Return the estimate, or a pose by the frames of localisations that publish no pose, or by odometry."""
        found = self.localisation.estimate()
        if found.pose is not None:
            return found
        if (placed := self._link.frames.pose(BASE, self._base.map_frame)) is not None:
            return found.model_copy(update={"unlocalized": placed, "unlocalized_frame": "map"})
        by_odometry = self._link.frames.pose(BASE, ODOMETRY_FRAME)
        if by_odometry is None and self._odometry is not None:
            with suppress(ValueError):  # an invalid orientation
                by_odometry = geometry.pose(self._odometry.pose.pose)
        return found.model_copy(update={"unlocalized": by_odometry, "unlocalized_frame": "odom"})

    async def _navigate(self, request: wire.NavigateThroughPoses) -> None:
        self._was_driven = True
        return await navigate(self._link, self._base, request)

    async def _drive(self, request: wire.Drive) -> None:
        check_drive_duration(request.duration)
        if request.lateral:
            raise RequestRefused(Result.OPERATION_FAILED, f"unsupported motion of {self._link.name} sideways")
        await self._velocity.check(request.linear, request.angular)
        self._was_driven = True
        standstills = self._link.state.standstills
        number = standstills.number

        async def drive() -> str:
            try:
                await anyio.sleep(request.duration)
                standstills.check(number)
            finally:
                self._velocity.stop()
            return ""

        command = partial(self._velocity.command, request.linear, request.angular, request.duration)
        self._link.work.start(request.id, drive, robot=self._link.name, begin=command)

    async def _cmd_vel(self, request: wire.CmdVel) -> None:
        linear, angular = request.twist.linear, request.twist.angular
        if any((linear.y, linear.z, angular.x, angular.y)):
            raise RequestRefused(
                Result.OPERATION_FAILED,
                "unsupported twist: expected a velocity along x and about z, and zeros else",
            )
        await self._velocity.check(linear.x, angular.z)
        self._link.work.check_free(self._link.name)
        self._was_driven = True
        self._velocity.command(linear.x, angular.z, DEADLINE)

    async def _watch_proximity(self, request: wire.WatchProximity) -> None:
        check_finite("point", request.point.x, request.point.y)
        check_positive("threshold", request.threshold)
        frames, wanted = self._link.frames, {request.frame, request.parent_frame}
        with anyio.move_on_after(FRAME_TIMEOUT):
            await self._link.intake.arrivals.wait_for(lambda: wanted <= frames.names)
        missing = wanted - frames.names
        if missing:
            raise RequestRefused(
                Result.NOT_FOUND,
                f"unknown frame {name_list(missing)} (frames of '{self._link.name}': {name_list(frames.names)})",
            )
        self._link.work.start(request.id, partial(self._wait_near, request))

    async def _wait_near(self, request: wire.WatchProximity) -> str:
        frames, point = self._link.frames, request.point

        def is_near() -> bool:
            distance = frames.distance(request.frame, request.parent_frame, point.x, point.y)
            return distance <= request.threshold

        await self._link.intake.arrivals.wait_for(is_near)
        return ""

    async def _watch_distance(self, request: wire.WatchDistance) -> None:
        check_positive("distance", request.distance)
        with anyio.move_on_after(DISCOVERY_TIMEOUT):
            await self._link.intake.arrivals.wait_for(lambda: self._odometry is not None)
        if self._odometry is None:
            topic = self._link.node.resolve(self._base.odometry)
            reason = self._link.explain_silence(topic)
            raise RequestRefused(Result.INCORRECT_STATE, f"no odometry of the robot on {topic}: {reason}")
        target = self._travelled + request.distance

        async def travel() -> str:
            await self._link.intake.arrivals.wait_for(lambda: self._travelled >= target)
            return ""

        self._link.work.start(request.id, travel)
