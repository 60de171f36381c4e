"""A robot of ROS 2, as the node serves it."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.arm import MovingArm
from seoro.bridges.ros2.robots.base import DrivingBase
from seoro.bridges.ros2.robots.frames import Frames
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.profile import Profile
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.robot import Handlers, Health
from seoro.bridges.serving.work import Work

TRANSFORMS = "tf2_msgs/msg/TFMessage"
BATTERY = "sensor_msgs/msg/BatteryState"
CHANGING = Qos(depth=100)
FIXED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=100)


class RosRobot:
    """A robot.

    Args:
        name: Its name, for scenarios.
        profile: What it is.
        link: To it.
        work: Where goals and watches run.
        happenings: What happens to it.
    """

    def __init__(self, name: str, profile: Profile, link: Link, work: Work, happenings: HappeningLog) -> None:
        self._name = name
        self._profile = profile
        self._link = link
        self._frames = Frames()
        self._battery: float | None = None
        self._base: DrivingBase | None = None
        if profile.base is not None:
            self._base = DrivingBase(link, profile.base, self._frames, name, work, happenings)
        self._arm = None if profile.arm is None else MovingArm(link, profile.arm, self._frames, name, work)

    @property
    def info(self) -> wire.RobotInfo:
        """What it is called and has; its frames are those that it has published so far."""
        return wire.RobotInfo(name=self._name, kinds=self._profile.kinds, frames=tuple(sorted(self._frames.names)))

    @property
    def handlers(self) -> Handlers:
        """The verbs that it serves."""
        parts = [part.handlers for part in (self._base, self._arm) if part is not None]
        return {verb: carry for handlers in parts for verb, carry in handlers.items()}

    @property
    def health(self) -> Health:
        """How it is: the charge of its battery, if it tells that, and where it believes to be."""
        localisation = None if self._base is None else self._base.localisation
        position = None if localisation is None else localisation.position
        return Health(
            battery=self._battery,
            localised=None if localisation is None else position is not None,
            deviation=None if localisation is None else localisation.deviation,
            position=position,
            seen=self._link.heard_ago(),
            topics=self._link.topics(),
        )

    def _take_battery(self, message: Message) -> None:
        charge = float(message.percentage)
        self._battery = charge if 0.0 <= charge <= 1.0 else None  # NaN where it is not known

    def _forget_battery(self) -> None:
        """Forget its charge: who tells of it is gone."""
        self._battery = None

    async def open(self) -> None:
        """Listen to it, and be ready to command it."""
        await self._link.listen(self._profile.battery, BATTERY, self._take_battery)
        await self._link.listen(self._profile.tf, TRANSFORMS, self._frames.take, CHANGING)
        await self._link.listen(self._profile.tf_static, TRANSFORMS, self._frames.take_static, FIXED)
        self._link.tasks.start_soon(self._link.watch_end, self._profile.tf, self.forget)
        self._link.tasks.start_soon(self._link.watch_end, self._profile.battery, self._forget_battery)
        if self._base is not None:
            await self._base.open()
        if self._arm is not None:
            await self._arm.open()

    def forget(self) -> None:
        """Forget where it was: time was set back, or it is gone, and may start anew."""
        self._frames.forget()
        if self._base is not None:
            self._base.forget()

    async def stop(self) -> None:
        """Command zero velocity; an arm stands still when its goal is canceled."""
        if self._base is not None:
            self._base.stop()

    async def end(self) -> None:
        """Keep a base that was driven at zero velocity for a while, when nothing is asked for any more."""
        if self._base is not None:
            await self._base.end()
