"""Declarations of drives: kinds, motors and limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, NonNegativeFloat, PositiveFloat, model_validator

from sim_nodes.files import Declared

Place = Annotated[float, Field(ge=-100.0, le=100.0)]  # [m]
Angle = Annotated[float, Field(ge=-math.pi, le=math.pi)]  # [rad]
MAX_ROLLER = math.radians(80)  # of rollers against the axle, beyond which a wheel cannot push
MAX_WHEELS = 16


class DriveKind(StrEnum):
    """Kinds of drives.

    A `skid_steer` drive is a differential one of more than two wheels.
    """

    DIFFERENTIAL = "differential"
    SKID_STEER = "skid_steer"
    OMNIDIRECTIONAL = "omnidirectional"
    ACKERMANN = "ackermann"


class DriveLimits(Declared):
    """Limits and motors of a drive of any kind."""

    max_speed: PositiveFloat  # [m/s]
    max_acceleration: PositiveFloat  # [m/s^2]
    max_turn_rate: PositiveFloat  # [rad/s]
    max_turn_acceleration: PositiveFloat  # [rad/s^2]
    motor_gain: PositiveFloat  # torque per speed error [N m s/rad]
    motor_torque: PositiveFloat  # limit [N m]
    armature: PositiveFloat  # inertia of rotor and gear at the wheel [kg m^2]
    wheel_friction: PositiveFloat


class DifferentialDrive(DriveLimits):
    """A differential drive: two wheels on one axle, at the origin of the base."""

    kind: Literal[DriveKind.DIFFERENTIAL] = DriveKind.DIFFERENTIAL
    left_joint: str
    right_joint: str
    wheel_radius: PositiveFloat  # [m]
    wheel_separation: PositiveFloat  # [m]

    @property
    def max_lateral_speed(self) -> float:
        """Maximum speed sideways [m/s]: zero."""
        return 0.0

    @property
    def min_turning_radius(self) -> float:
        """Smallest radius of a curve [m]: zero, since it turns in place."""
        return 0.0


class WheelDeclaration(Declared):
    """A wheel of a planar drive: its joint, and where it stands in the frame of the base.

    Rollers of an omni wheel turn about the direction of rolling: `roller` is 0. Those of a mecanum wheel are at
    45 degrees to it, to the left (positive) or right. A plain wheel has no rollers.
    """

    joint: str
    x: Place  # [m]
    y: Place
    radius: PositiveFloat  # [m]
    heading: Angle = 0.0  # direction of rolling without steering [rad]
    roller: Annotated[float, Field(ge=-MAX_ROLLER, le=MAX_ROLLER)] = 0.0  # axis of rollers to that direction [rad]
    steering: str | None = None  # joint that steers it


class PlanarDrive(DriveLimits):
    """A drive whose wheels skid, have rollers, or steer.

    Engines do not simulate its contacts: motors pull the base to the velocity of its wheels, with the traction of
    the wheels at most, and the wheels turn without friction. See `docs/how-to/drives.md`.
    """

    kind: Literal[DriveKind.SKID_STEER, DriveKind.OMNIDIRECTIONAL, DriveKind.ACKERMANN]
    wheels: Annotated[tuple[WheelDeclaration, ...], Field(min_length=2, max_length=MAX_WHEELS)]
    max_lateral_speed: NonNegativeFloat = 0.0  # [m/s] of an omnidirectional drive
    min_turning_radius: NonNegativeFloat = 0.0  # [m] of the origin of the base; of an Ackermann drive

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        kind = self.kind.value
        for name, of in (
            ("max_lateral_speed", DriveKind.OMNIDIRECTIONAL),
            ("min_turning_radius", DriveKind.ACKERMANN),
        ):
            value = getattr(self, name)
            if (self.kind is of) != (value > 0.0):
                wanted = "more than 0" if self.kind is of else "none"
                raise ValueError(f"invalid `{name}` {value:g} of the drive `{kind}`; expected {wanted}")
        names = [joint for wheel in self.wheels for joint in (wheel.joint, wheel.steering) if joint is not None]
        if len(set(names)) < len(names):
            raise ValueError("duplicate joint of a wheel")
        steered = [wheel for wheel in self.wheels if wheel.steering is not None]
        if bool(steered) != (self.kind is DriveKind.ACKERMANN):
            wanted = "one wheel or more with `steering`" if not steered else "wheels without `steering`"
            raise ValueError(f"expected {wanted} in the drive `{kind}`")
        if any(wheel.x < 1e-3 for wheel in steered):
            raise ValueError("expected steered wheels ahead of the base's origin, which is on the rear axle")
        return self

    @cached_property
    def steered(self) -> tuple[WheelDeclaration, ...]:
        """The steered wheels."""
        return tuple(wheel for wheel in self.wheels if wheel.steering is not None)


def _read_drive(value: Any) -> Any:
    """Read a drive by its kind, so that errors are those of one kind."""
    if not isinstance(value, Mapping):
        return value
    kind = value.get("kind", DriveKind.DIFFERENTIAL)
    return (DifferentialDrive if kind == DriveKind.DIFFERENTIAL else PlanarDrive).model_validate(value)


DriveDeclaration = Annotated[DifferentialDrive | PlanarDrive, BeforeValidator(_read_drive)]
"""A drive of any kind; `differential` without `kind`."""
