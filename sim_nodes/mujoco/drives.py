"""Drives in MuJoCo: addresses of wheels and motors."""

from __future__ import annotations

from typing import Any

from sim_nodes.mujoco.planar import PlanarMotors
from sim_nodes.robots.declaration import MobileDeclaration, RobotDeclaration
from sim_nodes.robots.drive_declaration import PlanarDrive
from sim_nodes.robots.kinematics import motor_joints, wheel_joints


class DriveAddresses:
    """Addresses of a robot's wheels in the arrays of a model."""

    def __init__(
        self, model: Any, robot: str, base: int, declaration: RobotDeclaration, mobile: MobileDeclaration
    ) -> None:
        prefix, drive = f"{robot}/", mobile.drive
        joints = [model.joint(prefix + name) for name in motor_joints(drive)]
        self.base = base
        self.wheel_positions = [int(joint.qposadr[0]) for joint in joints]
        self.wheel_angular_speeds = [int(joint.dofadr[0]) for joint in joints]
        self.motors = [model.actuator(joint.name).id for joint in joints]
        self._wheels = self.motors[: len(wheel_joints(drive))]
        self.planar = PlanarMotors(model, robot, declaration, drive) if isinstance(drive, PlanarDrive) else None
        self._gain = drive.motor_gain

    def power(self, model: Any, *, on: bool) -> None:
        """Switch the torque of the motors; joints that steer keep theirs."""
        gain = self._gain if on else 0.0
        model.actuator_gainprm[self._wheels, 0] = gain
        model.actuator_biasprm[self._wheels, 2] = -gain
        if self.planar is not None:
            self.planar.power(model, on=on)
