"""Wheel motors in PyBullet, with speeds as targets and limited torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sim_nodes.pybullet.model import Links, wheels
from sim_nodes.pybullet.output import captured_output
from sim_nodes.robots.declaration import MobileDeclaration

with captured_output():  # pybullet prints its build time on import
    import pybullet

BEARINGS = 0.002  # [N m] friction of wheels without power; frictionless wheels may creep forever


@dataclass(frozen=True)
class DriveCommand:
    """The last motor command: speeds of the left and right wheel [rad/s], and whether the motors have power."""

    speeds: tuple[float, float] = (0.0, 0.0)
    has_power: bool = True


class PybulletDrive:
    """The wheels of a robot.

    Args:
        bullet: The Bullet client.
        body: Number of the robot's body.
        links: Its links and joints.
        mobile: Declaration of its base.

    Attributes:
        body: Number of the robot's body.
        wheels: Joint numbers of the left and right wheel.
        command: The last command.
    """

    def __init__(self, bullet: Any, body: int, links: Links, mobile: MobileDeclaration) -> None:
        self._bullet, self.body = bullet, body
        self.wheels = wheels(links, mobile.drive)
        self._torque = mobile.drive.motor_torque
        self.apply_command(DriveCommand())

    def apply_command(self, command: DriveCommand) -> None:
        """Set the motor targets from a command."""
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
        """Stop the wheels at once."""
        for wheel, angle in zip(self.wheels, self.angles(), strict=True):
            self._bullet.resetJointState(self.body, wheel, angle, 0.0)
