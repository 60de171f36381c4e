"""Motion models of the particle filter: how far the robot may have moved for a motion by odometry."""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.robots.declaration import LocalisationDeclaration

STILL = 0.01  # [m]; shorter motions have no direction


def move_forwards(
    particles: Array, motion: Pose2, parameters: LocalisationDeclaration, random: np.random.Generator
) -> None:
    """Move particles of a robot that drives along its heading: a turn, a way, and a turn.

    The model is `odometry` of Thrun, Burgard, Fox 2005: "Probabilistic Robotics", table 5.6.

    Args:
        particles: Poses (x, y, yaw), which are changed, shape (n, 3).
        motion: Motion by odometry, in the frame of the base.
        parameters: Standard deviations.
        random: Source of random numbers.
    """
    p = parameters
    way = math.hypot(motion.x, motion.y)
    first = math.atan2(motion.y, motion.x) if way > STILL else 0.0
    second = wrap(motion.yaw - first)
    # Driving backwards does not start with half a turn.
    turn1 = min(abs(first), math.pi - abs(first))
    turn2 = min(abs(second), math.pi - abs(second))
    noise = random.standard_normal((3, len(particles)))
    rotation1 = first + noise[0] * math.sqrt(p.alpha1 * turn1**2 + p.alpha2 * way**2)
    distance = way + noise[1] * math.sqrt(p.alpha3 * way**2 + p.alpha4 * (turn1**2 + turn2**2))
    rotation2 = second + noise[2] * math.sqrt(p.alpha1 * turn2**2 + p.alpha2 * way**2)
    heading = particles[:, 2] + rotation1
    particles[:, 0] += distance * np.cos(heading)
    particles[:, 1] += distance * np.sin(heading)
    particles[:, 2] = heading + rotation2


def move_anywhere(
    particles: Array, motion: Pose2, parameters: LocalisationDeclaration, random: np.random.Generator
) -> None:
    """Move particles of an omnidirectional robot: a way in any direction, errors to its side, and a turn.

    Parameters have the meaning of those of Nav2's `OmniMotionModel`. Arguments are those of `move_forwards`.
    """
    p = parameters
    way, turn = math.hypot(motion.x, motion.y), abs(motion.yaw)
    noise = random.standard_normal((3, len(particles)))
    along = way + noise[0] * math.sqrt(p.alpha3 * way**2 + p.alpha1 * turn**2)
    aside = noise[1] * math.sqrt(p.alpha1 * turn**2 + p.alpha5 * way**2)
    bearing = particles[:, 2] + math.atan2(motion.y, motion.x)
    particles[:, 0] += along * np.cos(bearing) - aside * np.sin(bearing)
    particles[:, 1] += along * np.sin(bearing) + aside * np.cos(bearing)
    particles[:, 2] += motion.yaw + noise[2] * math.sqrt(p.alpha4 * turn**2 + p.alpha2 * way**2)
