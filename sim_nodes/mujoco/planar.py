"""Planar drives in MuJoCo: motors on the free joint of the base, and wheels that turn without friction."""

from __future__ import annotations

from typing import Any

import mujoco

from sim_nodes.mujoco.terrain import LOOSE_PRIORITY
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.drive_declaration import PlanarDrive
from sim_nodes.robots.kinematics import base_motion, steering_joints
from sim_nodes.robots.traction import COASTING, RESPONSE, Traction, traction_of

AXES = {"ahead": [1, 0, 0, 0, 0, 0], "left": [0, 1, 0, 0, 0, 0], "turn": [0, 0, 0, 0, 0, 1]}
ORIGIN = "base#origin"  # site
STEERING_FREQUENCY = 40.0  # [rad/s] of steering motors, critically damped


def motor_name(axis: str) -> str:
    """Return the name of a motor of the base."""
    return f"base#{axis}"


def add_planar_drive(spec: Any, declaration: RobotDeclaration, drive: PlanarDrive, floor_friction: float) -> None:
    """Add the motors of a planar drive to a robot."""
    for wheel in drive.wheels:
        joint = spec.joint(wheel.joint)
        joint.armature = drive.armature
        for geom in joint.parent.geoms:
            if geom.contype:
                geom.condim, geom.priority, geom.friction = 1, LOOSE_PRIORITY, [0.0, 0.0, 0.0]
        motor = _motor(spec, wheel.joint, drive)
        motor.set_to_velocity(kv=drive.motor_gain)
    for name in steering_joints(drive):
        joint = spec.joint(name)
        joint.armature = drive.armature
        gain = drive.armature * STEERING_FREQUENCY**2
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=gain, kv=2.0 * drive.armature * STEERING_FREQUENCY)
    spec.body(declaration.base_link).add_site(name=ORIGIN)
    traction = traction_of(declaration, drive, floor_friction)
    limits = (traction.force, traction.side_force, traction.torque)
    for (axis, gear), gain, limit in zip(AXES.items(), _gains(traction), limits, strict=True):
        motor = spec.add_actuator(name=motor_name(axis), target=ORIGIN, trntype=mujoco.mjtTrn.mjTRN_SITE)
        motor.gear = gear
        motor.set_to_velocity(kv=gain)
        motor.forcelimited = True
        motor.forcerange = [-limit, limit]


def _motor(spec: Any, joint: str, drive: PlanarDrive) -> Any:
    motor = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.forcelimited = True
    motor.forcerange = [-drive.motor_torque, drive.motor_torque]
    return motor


def _gains(traction: Traction) -> tuple[float, float, float]:
    """Return the gains of the motors of the base [N s/m], [N s/m], [N m s/rad]."""
    mass, inertia = traction.mass, traction.inertia
    return mass / RESPONSE, mass / RESPONSE, inertia / RESPONSE


class PlanarMotors:
    """The motors on the base of a robot.

    Args:
        model: Model of the scene.
        robot: Name of the robot.
        declaration: Its declaration.
        drive: Its drive.
    """

    def __init__(self, model: Any, robot: str, declaration: RobotDeclaration, drive: PlanarDrive) -> None:
        self._drive = drive
        self._traction = traction_of(declaration, drive)
        self._motors = [model.actuator(f"{robot}/{motor_name(axis)}").id for axis in AXES]

    def command(self, data: Any, motors: tuple[float, ...]) -> None:
        """Pull the base to the velocity by the values of its wheels and steering joints."""
        linear, angular, lateral = base_motion(self._drive, motors)
        data.ctrl[self._motors] = linear, lateral, angular

    def power(self, model: Any, *, on: bool) -> None:
        """Switch the motors; without power, the base coasts, and plain wheels do not slide sideways."""
        gains = _gains(self._traction)
        for motor, gain, resists in zip(
            self._motors, gains, (False, self._traction.holds_side, False), strict=True
        ):
            braking = gain if on or resists else gain * RESPONSE / COASTING
            model.actuator_gainprm[motor, 0] = gain if on or resists else 0.0
            model.actuator_biasprm[motor, 2] = -braking
