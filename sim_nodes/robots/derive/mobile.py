"""Declarations of mobile robots derived from their models."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from seoro.deferred import dataclass
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import Urdf
from sim_nodes.robots.declaration import ArmDeclaration, CameraDeclaration, MobileDeclaration, OdometryDeclaration
from sim_nodes.robots.derive.drives import DerivedDrive, derive_drive
from sim_nodes.robots.derive.jointed import kept_joints
from sim_nodes.robots.derive.model import RobotModel
from sim_nodes.robots.derive.outline import derive_footprint, is_supported, sliding_links
from sim_nodes.robots.derive.rewriting import Changes, canonical_text, changes_for
from sim_nodes.robots.derive.sensors import derive_sensors
from sim_nodes.robots.derive.wheels import find_wheels
from sim_nodes.robots.drive_declaration import DriveKind

KINDS = ("differential_drive_robot", "robot", "osc_actor")
KINDS_WITH_ARM = ("mobile_manipulator", "differential_drive_robot", "manipulator", "arm", "robot", "osc_actor")
BODY_FRICTION = 0.3
MARGIN = 0.02  # [m] of the clearance beyond the radius
ODOMETRY = OdometryDeclaration(distance_noise=0.01, turn_noise=0.02, drift_noise=0.02)


@dataclass(frozen=True)
class DerivedRobot:
    """A mobile robot by its model.

    Attributes:
        urdf: Canonical URDF with the changes that the drive needs.
        changes: These changes.
        drive: The drive, with its wheels in the model.
        mobile: Declaration of the base.
        base_link: Link of the base.
        low_friction_links: Links that slide on the floor.
        cameras: Its cameras.
        notes: Texts on changes of the model and missing parts.
    """

    urdf: Urdf
    changes: Changes
    drive: DerivedDrive
    mobile: MobileDeclaration
    base_link: str
    low_friction_links: tuple[str, ...]
    cameras: tuple[CameraDeclaration, ...]
    notes: tuple[str, ...]


def derive_mobile(
    model: RobotModel, kind: DriveKind, source: Any, arm: ArmDeclaration | None = None
) -> DerivedRobot:
    """Derive the declaration of a mobile robot.

    Args:
        model: Its model.
        kind: Kind of its drive.
        source: Root element of its file, for the sensors.
        arm: Declaration of the arm that it carries; its outline is that with the arm at home.

    Raises:
        RequestRefused: The model does not fit the kind of drive.
    """
    derived = derive_drive(model, kind, find_wheels(model))
    kept = frozenset() if arm is None else kept_joints(model, arm)
    if both := kept & {joint.name for joint in derived.motors}:
        raise xml.invalid(f"the arm moves {min(both)!r}, a wheel; name another link as `arm: {{tool_link: ...}}`")
    model = model if arm is None else model.at(arm.home)
    sensors = derive_sensors(model, derived.base, source)
    footprint = derive_footprint(model, derived.base)
    sliding = sliding_links(model, derived.base, derived.wheels)
    changes = changes_for(model, derived, kept)
    notes = [*changes.notes, *sensors.notes]
    if not is_supported(model, derived.base, derived.wheels, sliding):
        notes.append("its centre of mass is not between its wheels and casters: it may fall over")
    if sensors.lidar is None:
        notes.append("no lidar: it is localised by its odometry from the initial pose on, and sees nothing")
    radius = round(footprint.radius, 4)
    mobile = MobileDeclaration(
        radius=radius,
        footprint=footprint,
        clearance=round(radius + MARGIN, 4),
        drive=derived.drive,
        odometry=ODOMETRY,
        lidar=sensors.lidar,
        imu=sensors.imu,
    )
    urdf = replace(model.urdf, text=canonical_text(model, changes))
    return DerivedRobot(urdf, changes, derived, mobile, changes.base, sliding, sensors.cameras, tuple(notes))
