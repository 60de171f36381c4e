"""From where and how pictures are taken: lenses, views, and the geometry of looking at something.

A camera's own frame has x ahead, y to the left and z up, as that of a robot's base (REP 103).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Quaternion, Vector, quaternion, rotation_matrix

Picture = NDArray[np.uint8]
"""Red, green, blue by row from the top and column from the left, shape (height, width, 3)."""

MIN_FOV, MAX_FOV = math.radians(1.0), math.radians(150.0)  # [rad]
MIN_SIZE, MAX_SIZE = 16, 2048  # [pixels] of an edge of a picture
NEAR, FAR = 0.02, 200.0  # [m] before a camera, between which things are seen
ELEVATION = math.radians(52.0)  # of the view of a whole world
COSINE, SINE = math.cos(ELEVATION), math.sin(ELEVATION)
MARGIN = 1.04  # of its distance
STRAIGHT = 1e-9  # [m] of horizontal distance below which a camera looks straight up or down


class NoRendering(Exception):
    """Pictures cannot be drawn on this machine; the message says what is missing."""


@dataclass(frozen=True)
class Lens:
    """A pinhole camera without distortion."""

    fov: float = math.radians(45.0)  # vertical field of view [rad]
    width: int = 640  # [pixels]
    height: int = 480

    @property
    def aspect(self) -> float:
        """Width by height."""
        return self.width / self.height


DEFAULT_LENS = Lens()


@dataclass(frozen=True)
class View:
    """A lens at a place in the map, looking along the x axis of its orientation."""

    position: Vector
    orientation: Quaternion
    lens: Lens

    @property
    def axes(self) -> tuple[Array, Array]:
        """Unit vectors ahead and up, in the map."""
        matrix = rotation_matrix(self.orientation)
        return matrix[:, 0], matrix[:, 2]


def looking_at(position: Vector, target: Vector) -> Quaternion:
    """The orientation of an upright camera that has a point in the middle of its picture.

    Straight up or down, the top of the picture is towards +y.
    """
    x, y, z = (target[i] - position[i] for i in range(3))
    ground = math.hypot(x, y)
    yaw = math.atan2(y, x) if ground > STRAIGHT else math.pi / 2
    return quaternion(0.0, -math.atan2(z, ground), yaw)


def overview(
    extent: tuple[float, float, float, float], height: float, lens: Lens, others: Sequence[Vector] = ()
) -> View:
    """A view from the south and above in which all of a world is seen.

    Args:
        extent: Of the world: lower x, lower y, upper x, upper y [m].
        height: Of what stands in it [m].
        lens: The lens.
        others: Points that are to be seen, too [m].
    """
    left, bottom, right, top = extent
    centre = np.array([(left + right) / 2, (bottom + top) / 2, height / 2])
    back, up = np.array([0.0, -COSINE, SINE]), np.array([0.0, SINE, COSINE])
    corners = np.array([*itertools.product((left, right), (bottom, top), (0.0, height)), *others]) - centre
    nearer = corners @ back
    slope = math.tan(lens.fov / 2)
    # How far back a camera on the axis has to be for all corners to be below, above, and between edges.
    below = float((corners @ up / slope + nearer).max())
    above = float((-corners @ up / slope + nearer).max())
    between = float((np.abs(corners[:, 0]) / (slope * lens.aspect) + nearer).max())
    distance = MARGIN * max((below + above) / 2, between)
    place = centre + distance * back + (below - above) / 2 * slope * up
    x, y, z = place.tolist()
    return View((x, y, z), quaternion(0.0, ELEVATION, math.pi / 2), lens)
