"""What robots drive with in PyBullet: motors that turn wheels at speeds within their torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sim_nodes.pybullet.model import Links, wheels
from sim_nodes.pybullet.output import caught
from sim_nodes.robots.declaration import MobileDeclaration

with caught():  # it prints when it was built
    import pybullet

BEARINGS = 0.002  # [N m] of friction in wheels without power; those without any may creep on for ever


@dataclass(frozen=True)
class DriveCommand:
    """What motors were told last: speeds of the left and the right wheel [rad/s], and whether they have power."""

    speeds: tuple[float, float] = (0.0, 0.0)
    has_power: bool = True


class PybulletDrive:
    """The wheels of a robot.

    Args:
        bullet: Bullet.
        body: Number of the robot's body.
        links: Its links and joints.
        mobile: What is declared of its base.

    Attributes:
        body: See above.
        wheels: Numbers of the joints of the left and the right wheel.
        command: What the motors were told last.
    """

    def __init__(self, bullet: Any, body: int, links: Links, mobile: MobileDeclaration) -> None:
        self._bullet, self.body = bullet, body
        self.wheels = wheels(links, mobile.drive)
        self._torque = mobile.drive.motor_torque
        self.take_up(DriveCommand())

    def take_up(self, command: DriveCommand) -> None:
        """Have the motors obey a command."""
        self.command = command
        speeds, torque = (command.speeds, self._torque) if command.has_power else ((0.0, 0.0), BEARINGS)
        self._bullet.setJointMotorControlArray(
            self.body,
            self.wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=speeds,
            forces=[torque, torque],
        )

    def angles(self) -> tuple[float, float]:
        """See `Engine.wheel_angles`."""
        left, right = pybullet.getJointStates(self.body, self.wheels, self._bullet._client)
        return left[0], right[0]

    def stop(self) -> None:
        """Bring the wheels to rest at once."""
        for wheel, angle in zip(self.wheels, self.angles(), strict=True):
            self._bullet.resetJointState(self.body, wheel, angle, 0.0)
