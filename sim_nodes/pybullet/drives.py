"""Drives in PyBullet: motors of wheels and steering joints."""

from __future__ import annotations

from typing import Any

import pybullet

from seoro.deferred import dataclass
from sim_nodes.pybullet.model import Links, motors
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.kinematics import per_motor, wheel_joints

STEERING_TORQUE = 100.0  # [N m]
BEARINGS = 0.002  # [N m] friction of wheels without power; frictionless wheels may creep forever


@dataclass(frozen=True)
class DriveCommand:
    """The last motor command: targets as in `Engine.command_wheels`, and whether the motors have power."""

    targets: tuple[float, ...]
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
        motors: Joint numbers of the motors.
        command: The last command.
    """

    def __init__(self, bullet: Any, body: int, links: Links, mobile: MobileDeclaration) -> None:
        self._bullet, self.body = bullet, body
        self.drive: DriveDeclaration = mobile.drive
        self.motors = motors(links, mobile.drive)
        self._count = len(wheel_joints(mobile.drive))
        self._torque = mobile.drive.motor_torque
        self.apply_command(DriveCommand(per_motor(mobile.drive, 0.0, 0.0, 0.0)))

    def apply_command(self, command: DriveCommand) -> None:
        """Set the motor targets from a command."""
        self.command = command
        count = self._count
        speeds, torque = command.targets[:count], self._torque
        if not command.has_power:
            speeds, torque = (0.0,) * count, BEARINGS
        self._bullet.setJointMotorControlArray(
            self.body,
            self.motors[:count],
            pybullet.VELOCITY_CONTROL,
            targetVelocities=speeds,
            forces=[torque] * count,
        )
        for joint, angle in zip(self.motors[count:], command.targets[count:], strict=True):
            self._bullet.setJointMotorControl2(
                self.body, joint, pybullet.POSITION_CONTROL, targetPosition=angle, force=STEERING_TORQUE
            )

    def angles(self) -> tuple[float, ...]:
        """See `Engine.wheel_angles`."""
        states = pybullet.getJointStates(self.body, self.motors, self._bullet._client)
        return tuple([state[0] for state in states])

    @property
    def is_commanded(self) -> bool:
        """Whether a command moves the wheels."""
        return self.command.has_power and any(self.command.targets)

    def stop(self) -> None:
        """Stop the wheels at once."""
        for wheel, angle in zip(self.motors, self.angles(), strict=True):
            self._bullet.resetJointState(self.body, wheel, angle, 0.0)
