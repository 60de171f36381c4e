"""The motor of a planar drive: forces on the base that stand for those of its wheels on the floor.

Forces act at the origin of the base, on the floor, along its axes. They pull the base to the speed of its wheels.
The friction of the wheels limits them, and so does the torque of the motors along the direction of travel.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

from defusedxml import ElementTree

from seoro.deferred import dataclass
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.drive_declaration import DriveKind, PlanarDrive
from sim_nodes.terrain.ground import FLOOR_FRICTION

GRAVITY = 9.81  # [m/s^2]
RESPONSE = 0.015  # [s] in which the base reaches the velocity of its wheels, without a limit
COASTING = 1.0  # [s] in which a base without power loses 63 % of its speed


@dataclass(frozen=True)
class Traction:
    """Motor of a base.

    Attributes:
        mass: Mass of the robot [kg].
        inertia: Its moment of inertia about the vertical axis, as of a disc as wide as its wheels [kg m^2].
        force: Largest force forwards [N].
        side_force: Largest force sideways [N].
        torque: Largest torque about the vertical axis [N m].
        lever: Half the distance of the forces that make up the torque [m].
        holds_side: Whether it resists motion sideways without power.
    """

    mass: float
    inertia: float
    force: float
    side_force: float
    torque: float
    lever: float
    holds_side: bool


@lru_cache(maxsize=64)
def traction_of(
    declaration: RobotDeclaration, drive: PlanarDrive, floor_friction: float = FLOOR_FRICTION
) -> Traction:
    """Return the motor of a robot's base on a floor."""
    root: Any = ElementTree.fromstring(declaration.urdf)
    mass = sum(float(each.get("value")) for each in root.findall("link/inertial/mass"))
    grip = drive.wheel_friction * floor_friction * mass * GRAVITY
    by_motors = sum(drive.motor_torque / wheel.radius for wheel in drive.wheels)
    lever = sum(math.hypot(wheel.x, wheel.y) for wheel in drive.wheels) / len(drive.wheels)
    is_omnidirectional = drive.kind is DriveKind.OMNIDIRECTIONAL
    force = min(grip, by_motors)
    return Traction(
        mass,
        mass * lever**2 / 2.0,
        force,
        force if is_omnidirectional else grip,
        force * lever,
        lever,
        not is_omnidirectional,
    )
