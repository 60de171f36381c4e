"""Places where the bumper of a robot has touched something, for its obstacle layer."""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array, Pose2
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.sensors.base import Bumps
from sim_nodes.sensors.sensor_pipeline import SensorPipeline

NOWHERE = np.zeros((0, 2))


def touched_places(bumper: SensorPipeline[Bumps] | None, declaration: MobileDeclaration, pose: Pose2) -> Array:
    """Return the middle of each pressed zone on the outline of a robot, in `map`, shape (n, 2) [m].

    Args:
        bumper: Its bumper; None without one.
        declaration: Declaration of the robot.
        pose: Localised pose in `map`.
    """
    if bumper is None or bumper.latest is None or not bumper.latest.data.bumps or declaration.bumper is None:
        return NOWHERE
    pressed = {bump.zone for bump in bumper.latest.data.bumps}
    bearings = [(zone.start + zone.end) / 2.0 for zone in declaration.bumper.zones if zone.name in pressed]
    return np.array([pose.compose(_on_outline(declaration, bearing))[:2] for bearing in bearings])


def _on_outline(declaration: MobileDeclaration, bearing: float) -> Pose2:
    """Return the place on the outline in a direction from the base's origin [rad], in the frame of the base."""
    outline = declaration.footprint
    away = declaration.radius if outline is None else outline.distance_to_edge(bearing)
    return Pose2(away * math.cos(bearing), away * math.sin(bearing), 0.0)
