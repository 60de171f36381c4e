"""A ROS 2 robot as a robot of a node."""

from __future__ import annotations

from collections.abc import Awaitable
from functools import partial
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.arm import MovingArm
from seoro.bridges.ros2.robots.base import DrivingBase
from seoro.bridges.ros2.robots.checks import check_robot
from seoro.bridges.ros2.robots.link import RobotLink
from seoro.bridges.ros2.robots.parts import BATTERY, TRANSFORMS
from seoro.bridges.ros2.robots.profile import Profile
from seoro.bridges.ros2.robots.sensing import Sensing
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.bridges.serving.robot import Carry, Handlers

BASE = "base_link"
UNINFORMED = frozenset({wire.DRIVE, wire.CMD_VEL})  # reading messages would delay velocities, which need none
DYNAMIC = Qos(depth=100)
STATIC = Qos(durability=Durability.TRANSIENT_LOCAL, depth=100)


class RosRobot:
    """A robot.

    Args:
        profile: Profile of the robot.
        link: Link to the robot.
    """

    def __init__(self, profile: Profile, link: RobotLink) -> None:
        self._profile = profile
        self._link = link
        self._battery: float | None = None
        self._base = None if profile.base is None else DrivingBase(link, profile.base)
        self._arm = None if profile.arm is None else MovingArm(link, profile.arm)
        self._sensing = Sensing(link, profile.sensors)

    @property
    def info(self) -> wire.RobotInfo:
        """Name and features of the robot, with the frames published so far."""
        self._link.intake.read()
        frames = tuple(sorted(self._link.frames.names))
        return wire.RobotInfo(name=self._link.name, kinds=self._profile.kinds, frames=frames)

    @property
    def handlers(self) -> Handlers:
        """Handlers of the served verbs; all but `UNINFORMED` see each message that arrived before the request."""
        parts = [part.handlers for part in (self._base, self._arm, self._sensing) if part is not None]
        own: Handlers = {wire.GET_ROBOT_DESCRIPTION: self._describe, wire.CHECK_ROBOT: self._check}
        served = {**own, **{verb: carry for handlers in parts for verb, carry in handlers.items()}}
        return {verb: carry if verb in UNINFORMED else self._informed(carry) for verb, carry in served.items()}

    def _informed(self, carry: Carry) -> Carry:
        def read_and_carry(request: Any) -> Awaitable[wire.Message | None]:
            self._link.intake.read()
            return carry(request)

        return read_and_carry

    @property
    def health(self) -> wire.RobotHealth:
        """State of the robot: battery charge and estimated position, if known."""
        self._link.intake.read()
        localisation = None if self._base is None else self._base.localisation
        position = None if localisation is None else localisation.position
        return wire.RobotHealth(
            battery=self._battery,
            localised=None if localisation is None else position is not None,
            deviation=None if localisation is None else localisation.deviation,
            position=position,
            seen=self._link.last_received(),
            topics=self._link.topics(),
        )

    async def _check(self, _request: wire.RobotName) -> wire.RobotCheck:
        return wire.RobotCheck(problems=await check_robot(self._profile, self._link))

    async def _describe(self, _request: wire.RobotName) -> wire.RobotDescription:
        """Describe the robot by its profile."""
        profile = self._profile
        return wire.RobotDescription(
            urdf="",
            base_link=BASE if profile.arm is None else profile.arm.base_frame,
            sensors=(*profile.sensors.force, *profile.sensors.sight),
            arm=None if self._arm is None else self._arm.description,
            max_speed=0.0 if profile.base is None else profile.base.limits.linear,
            max_turn_rate=0.0 if profile.base is None else profile.base.limits.angular,
        )

    def _on_battery(self, message: Message) -> None:
        charge = float(message.percentage)
        self._battery = charge if 0.0 <= charge <= 1.0 else None  # NaN if it is unknown

    def _forget_battery(self) -> None:
        """Forget the charge: its publisher has disappeared."""
        self._battery = None

    async def open(self) -> None:
        """Subscribe to the topics of the robot, and prepare commands."""
        frames = self._link.frames
        put_static = partial(frames.put, is_static=True)
        await self._link.listen(self._profile.battery, BATTERY, self._on_battery, forget=self._forget_battery)
        await self._link.listen(self._profile.tf, TRANSFORMS, frames.put, DYNAMIC, self.forget)
        await self._link.listen(self._profile.tf_static, TRANSFORMS, put_static, STATIC)
        if self._base is not None:
            await self._base.open()
        if self._arm is not None:
            await self._arm.open()
        await self._sensing.open()

    def forget(self) -> None:
        """Forget the poses of the robot: the time was set back, or the robot has disappeared."""
        self._link.intake.read()
        self._link.frames.forget()
        if self._base is not None:
            self._base.forget()

    async def stop(self) -> None:
        """Command zero velocity. An arm stops when its goal is canceled."""
        if self._base is not None:
            self._base.stop()

    async def end(self) -> None:
        """Command zero velocity for a while if the base was ever driven, after all other commands."""
        if self._base is not None:
            await self._base.end()
