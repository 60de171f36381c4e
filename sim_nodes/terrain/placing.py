"""Poses on terrain: robots stand on it, tilted as it is; bodies are above it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sim_nodes.extents import bounding_box, outline, points_of
from sim_nodes.geometry import Array, Quaternion, multiply, quaternion, rotated
from sim_nodes.physics import IDENTITY, START_CLEARANCE, BodyModel, BodyState, Wall
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.terrain.ground import Ground

RINGS, SPOKES = (0.5, 1.0), 12  # points of a disc: shares of its radius, and points of each ring
STANDING_RADIUS = 0.3  # [m] of ground under a robot without wheels
SUNK = 0.005  # [m] below the ground from which a pose is raised
SAMPLES = 9  # points along each axis under a body
SPACING = 0.05  # [m] between points under a wall
MAX_SAMPLES = 2000  # along a wall


def disc(radius: float) -> Array:
    """Return points of a disc around the origin, its centre first, shape (n, 2) [m]."""
    angles = np.arange(SPOKES) * (2.0 * math.pi / SPOKES)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    return np.vstack([np.zeros((1, 2)), *(share * radius * circle for share in RINGS)])


def stance(ground: Ground, x: float, y: float, radius: float) -> tuple[float, Quaternion]:
    """Return how a robot stands on the ground.

    The plane is the least-squares plane of the ground under the robot, raised to its highest point.

    Args:
        ground: The ground.
        x: Position of the robot [m].
        y: Position of the robot [m].
        radius: Radius of the ground under it [m].

    Returns:
        Height of the plane at the position [m], and the rotation from level to the plane.
    """
    points = disc(radius)
    heights = ground.heights(points[:, 0] + x, points[:, 1] + y)
    terms = np.column_stack([np.ones(len(points)), points])
    fitted = np.linalg.lstsq(terms, heights, rcond=None)[0]
    above = float((heights - terms @ fitted).max())
    base, ahead, left = fitted.tolist()
    if max(abs(ahead), abs(left)) < 1e-9:
        return base + above, IDENTITY
    steep = math.hypot(ahead, left)
    half = math.atan(steep) / 2.0
    # About the level line of the plane.
    share = math.sin(half) / steep
    return base + above, (math.cos(half), left * share, -ahead * share, 0.0)


def radius_of(declaration: RobotDeclaration) -> float:
    """Return the radius of the ground under a robot [m]."""
    return STANDING_RADIUS if declaration.mobile is None else declaration.mobile.radius


def steepness(tilt: Quaternion) -> float:
    """Return the angle of a tilted plane from level [rad]."""
    return math.acos(min(1.0, rotated(tilt, (0.0, 0.0, 1.0))[2]))


def standing(ground: Ground, declaration: RobotDeclaration, state: BodyState) -> BodyState:
    """Return the state of a robot's base, put on terrain that it would be in.

    Args:
        ground: The ground.
        declaration: The robot.
        state: State of its base.
    """
    x, y, z = state.position
    if ground.is_flat or declaration.fixed:
        return state
    height, tilt = stance(ground, x, y, radius_of(declaration))
    above = (declaration.standing_height + START_CLEARANCE) / math.cos(steepness(tilt))
    if height < SUNK or z >= height + above - SUNK:
        return state
    turned = multiply(tilt, quaternion(0.0, 0.0, state.planar.yaw))
    return replace(state, position=(x, y, height + above), orientation=turned)


def lift_onto(ground: Ground, model: BodyModel, state: BodyState) -> float:
    """Return by how much a body has to be raised to be on terrain [m]; 0 if no corner of it is in terrain.

    Args:
        ground: The ground.
        model: The body.
        state: Its state.
    """
    if ground.is_flat or not model.parts:
        return 0.0
    if model.driven:
        x, y, z = state.position
        top = float(tops(ground, np.array([[x, y]]), np.array([spread(model)]))[0])
        return top if z < top else 0.0
    corners = np.vstack([points_of(part, state) for part in model.parts])
    below = ground.heights(corners[:, 0], corners[:, 1])
    if not ((below > SUNK) & (corners[:, 2] < below - SUNK)).any():
        return 0.0
    return max(0.0, height_under(ground, model, state) - float(corners[:, 2].min()))


def raised(state: BodyState, lift: float) -> BodyState:
    """Return a state with a greater height [m]."""
    x, y, z = state.position
    return replace(state, position=(x, y, z + lift)) if lift else state


def height_under(ground: Ground, model: BodyModel, state: BodyState) -> float:
    """Return the greatest height of the ground under a body [m]."""
    if ground.is_flat or not model.parts:
        return 0.0
    seen = np.vstack([outline(part, state) for part in model.parts])
    axes = [np.linspace(low, high, SAMPLES) for low, high in zip(seen.min(axis=0), seen.max(axis=0), strict=True)]
    xs, ys = np.meshgrid(*axes)
    return float(ground.heights(xs, ys).max())


def grounded(ground: Ground, wall: Wall) -> Wall:
    """Return a wall from the lowest ground under it to its height above the highest."""
    if ground.is_flat:
        return wall
    heights = ground.heights(*_under(wall))
    low, high = float(heights.min()), float(heights.max())
    return replace(wall, z=wall.z + low, height=wall.height + high - low)


def _under(wall: Wall) -> tuple[Array, Array]:
    """Return points under a wall, x and y [m]."""
    counts = (min(MAX_SAMPLES, 2 + math.ceil(edge / SPACING)) for edge in (wall.length, wall.thickness))
    along, left = np.meshgrid(
        *(
            np.linspace(-edge / 2.0, edge / 2.0, count)
            for edge, count in zip((wall.length, wall.thickness), counts, strict=True)
        )
    )
    cos, sin = math.cos(wall.yaw), math.sin(wall.yaw)
    return wall.x + cos * along - sin * left, wall.y + sin * along + cos * left


def spread(model: BodyModel) -> float:
    """Return the radius of an upright body, seen from above [m]."""
    box = bounding_box(model.parts)
    assert box is not None, "people and carts have shapes"
    return math.hypot(*np.maximum(-box.lower, box.upper)[:2].tolist())


def tops(ground: Ground, places: Array, radii: Array) -> Array:
    """Return the greatest height of the ground under upright bodies, shape (n,) [m].

    Args:
        ground: The ground.
        places: Positions of the bodies, shape (n, 2) [m].
        radii: Their radii, shape (n,) [m].
    """
    points = places[:, None] + radii[:, None, None] * disc(1.0)
    highest: Array = ground.heights(points[..., 0], points[..., 1]).max(axis=1)
    return highest
