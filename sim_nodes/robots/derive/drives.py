"""Drives derived from wheels: places, limits and motors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from seoro.bridges.wire.refusal import name_list
from seoro.deferred import dataclass
from sim_nodes.geometry import wrap
from sim_nodes.models import xml_reading as xml
from sim_nodes.robots.derive.model import ModelJoint, RobotModel
from sim_nodes.robots.derive.wheels import BaseFrame, Wheel, base_frame, driven_wheels
from sim_nodes.robots.drive_declaration import DifferentialDrive, DriveKind, PlanarDrive, WheelDeclaration

GRAVITY = 9.81  # [m/s^2]
SPEED = 0.5  # [m/s] of robots without limits of their wheels
FASTEST = 5.0  # [m/s]
TURN_RATE = 2.0  # [rad/s]
ACCELERATION, TURN_ACCELERATION = 1.0, 4.0  # [m/s^2], [rad/s^2]
FRICTION = 1.2  # of wheels
STEERING_LIMIT = 0.6  # [rad] of joints without limits
GRIP_ERROR = 0.5  # [rad/s] speed error at which a wheel pushes with its whole weight
SPARE = 5.0  # default torque of a motor, by the torque with which its wheel slips
WEAKEST = 0.05  # smallest acceleration by motors, by gravity
MECANUM = math.pi / 4  # [rad]
DIGITS = 6  # of derived numbers


@dataclass(frozen=True)
class DerivedDrive:
    """A drive, the frame of its base, and its wheels."""

    drive: DifferentialDrive | PlanarDrive
    base: BaseFrame
    wheels: tuple[Wheel, ...]

    @property
    def motors(self) -> tuple[ModelJoint, ...]:
        """Joints of its motors."""
        steering = (wheel.steering for wheel in self.wheels if self.drive.kind is DriveKind.ACKERMANN)
        return (*(wheel.joint for wheel in self.wheels), *(joint for joint in steering if joint is not None))


def derive_drive(model: RobotModel, kind: DriveKind, wheels: Sequence[Wheel]) -> DerivedDrive:
    """Derive a drive; a differential one with more than two wheels becomes `skid_steer`.

    Raises:
        RequestRefused: The wheels do not fit the kind.
    """
    used = tuple(wheels) if kind is DriveKind.ACKERMANN else driven_wheels(wheels)
    if kind is DriveKind.DIFFERENTIAL and len(used) > 2:
        kind = DriveKind.SKID_STEER
    _check_wheels(kind, used, wheels)
    base = base_frame(kind, used)
    if kind is DriveKind.DIFFERENTIAL:
        return DerivedDrive(_differential(model, base, used), base, used)
    return DerivedDrive(_planar(model, kind, base, used), base, used)


def _check_wheels(kind: DriveKind, used: Sequence[Wheel], found: Sequence[Wheel]) -> None:
    least = {DriveKind.OMNIDIRECTIONAL: 3, DriveKind.ACKERMANN: 3}.get(kind, 2)
    if len(used) < least:
        names = name_list(wheel.joint.name for wheel in found) if found else "none"
        raise xml.invalid(
            f"found {len(used)} driven wheels for the drive `{kind.value}`; expected {least} or more. Wheels are "
            f"round links on the floor with continuous joints about level axes, found: {names}. Declare `mobile` "
            "with all keys instead of `drive`, or correct the model"
        )
    if kind is DriveKind.ACKERMANN:
        steered = [wheel for wheel in used if wheel.steering is not None]
        if not steered or len(steered) == len(used):
            raise xml.invalid(
                f"found {len(steered)} of {len(used)} wheels with a steering joint; expected those of the front "
                "axle for the drive `ackermann`"
            )


# ------------------------------------------------------------ limits and motors


@dataclass(frozen=True)
class _Limits:
    max_speed: float
    max_acceleration: float
    max_turn_rate: float
    max_turn_acceleration: float
    motor_gain: float
    motor_torque: float
    armature: float
    wheel_friction: float


def _limits(model: RobotModel, base: BaseFrame, wheels: Sequence[Wheel]) -> _Limits:
    """Return limits and motors: those of the joints, or defaults by mass and radius of the wheels."""
    speed = min(FASTEST, *(wheel.joint.velocity * wheel.radius for wheel in wheels))
    if math.isinf(min(wheel.joint.velocity for wheel in wheels)):
        speed = min(speed, SPEED)
    lever = max(math.hypot(*base.place(wheel.centre)) for wheel in wheels)
    radius = max(wheel.radius for wheel in wheels)
    slipping = model.mass * GRAVITY * radius / len(wheels)  # torque of a wheel that pushes with its weight [N m]
    torque = min(wheel.joint.effort for wheel in wheels)
    torque = SPARE * slipping if math.isinf(torque) else torque
    if torque < WEAKEST * slipping:
        raise xml.invalid(
            f"the motors of the wheels have an effort limit of {torque:g} N m; expected more than "
            f"{WEAKEST * slipping:.3g} N m to move {model.mass:.3g} kg"
        )
    friction = min(model.urdf.friction.get(wheel.joint.child, FRICTION) for wheel in wheels)
    return _Limits(
        speed,
        ACCELERATION,
        min(TURN_RATE, speed / lever),
        TURN_ACCELERATION,
        slipping / GRIP_ERROR,
        torque,
        model.mass * radius**2 / len(wheels),
        friction,
    )


def _rounded(limits: _Limits) -> dict[str, float]:
    return {key: round(value, DIGITS) for key, value in vars(limits).items()}


def _differential(model: RobotModel, base: BaseFrame, wheels: Sequence[Wheel]) -> DifferentialDrive:
    placed = sorted((base.place(wheel.centre)[1], wheel.joint.name) for wheel in wheels)
    (right, right_joint), (left, left_joint) = placed
    return DifferentialDrive(
        left_joint=left_joint,
        right_joint=right_joint,
        wheel_radius=round(sum(wheel.radius for wheel in wheels) / 2, DIGITS),
        wheel_separation=round(left - right, DIGITS),
        **_rounded(_limits(model, base, wheels)),
    )


def _planar(model: RobotModel, kind: DriveKind, base: BaseFrame, wheels: Sequence[Wheel]) -> PlanarDrive:
    assert kind is not DriveKind.DIFFERENTIAL
    declared = tuple(_declared(kind, base, wheels))
    limits = _rounded(_limits(model, base, wheels))
    radius = round(_turning_radius(declared, wheels), 3) if kind is DriveKind.ACKERMANN else 0.0
    if radius:
        limits["max_turn_rate"] = min(TURN_RATE, round(limits["max_speed"] / radius, DIGITS))
    return PlanarDrive(
        kind=kind,
        wheels=declared,
        max_lateral_speed=limits["max_speed"] if kind is DriveKind.OMNIDIRECTIONAL else 0.0,
        min_turning_radius=radius,
        **limits,
    )


def _declared(kind: DriveKind, base: BaseFrame, wheels: Sequence[Wheel]) -> Iterator[WheelDeclaration]:
    are_parallel = all(abs(wrap(wheel.heading - base.yaw)) < MECANUM / 2 for wheel in wheels)
    for wheel in wheels:
        x, y = (round(value, DIGITS) for value in base.place(wheel.centre))
        # The usual mounting: on the floor, the axes of the rollers form a rhombus.
        is_mecanum = kind is DriveKind.OMNIDIRECTIONAL and are_parallel
        heading = 0.0 if kind is not DriveKind.OMNIDIRECTIONAL or are_parallel else wrap(wheel.heading - base.yaw)
        yield WheelDeclaration(
            joint=wheel.joint.name,
            x=x,
            y=y,
            radius=round(wheel.radius, DIGITS),
            heading=round(heading, DIGITS),
            roller=round(math.copysign(MECANUM, -x * y), DIGITS) if is_mecanum else 0.0,
            steering=wheel.steering.name if kind is DriveKind.ACKERMANN and wheel.steering is not None else None,
        )


def _turning_radius(declared: Sequence[WheelDeclaration], wheels: Sequence[Wheel]) -> float:
    """Return the radius of the tightest curve [m]: that of the inner wheel at the limit of its joint."""
    joints = [wheel.steering for wheel in wheels if wheel.steering is not None]
    limits = [min(abs(joint.lower), abs(joint.upper)) for joint in joints]
    limit = min(limits, default=math.inf)
    limit = STEERING_LIMIT if math.isinf(limit) or not limit else min(limit, math.pi / 2)
    steered = [wheel for wheel in declared if wheel.steering is not None]
    return max(wheel.x / math.tan(limit) + abs(wheel.y) for wheel in steered)
