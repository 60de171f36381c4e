"""Views of cameras, and colours of things in images: red, green, blue, opacity, from 0 to 1.

A camera's frame has x forwards, y to the left and z up, as a robot's base (REP 103).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Quaternion, Vector, quaternion, rotation_matrix, vector

Picture = NDArray[np.uint8]
"""Red, green, blue by row from the top and column from the left, shape (height, width, 3)."""

Depths = NDArray[np.float32]
"""Distances along the view [m] by row and column, shape (height, width); infinite without a surface."""


@dataclass(frozen=True)
class DepthImage:
    """Distances and entities of the surfaces in a view.

    Attributes:
        depths: Distances.
        entities: Indices in `names` by row and column, shape (height, width); -1 without a surface.
        names: Names of the visible entities, sorted; `floor` is one of them.
    """

    depths: Depths
    entities: NDArray[np.int32]
    names: tuple[str, ...]

    @classmethod
    def of(cls, depths: Depths, ids: NDArray[np.int32], owners: Callable[[int], str | None]) -> DepthImage:
        """Make an image from ids of an engine.

        Args:
            depths: Distances.
            ids: Ids by row and column.
            owners: Returns the entity of an id; None for no surface.
        """
        found, places = np.unique(ids, return_inverse=True)
        entities = [owners(each) for each in found.tolist()]
        names = tuple(sorted({each for each in entities if each is not None}))
        indices = np.array([-1 if each is None else names.index(each) for each in entities], dtype=np.int32)
        return cls(depths, indices[places].reshape(ids.shape), names)


MIN_FOV, MAX_FOV = math.radians(1.0), math.radians(150.0)  # [rad]
MIN_SIZE, MAX_SIZE = 16, 2048  # [pixels] of each dimension
NEAR, FAR = 0.02, 200.0  # [m] from the camera, near and far clipping distance
ELEVATION = math.radians(52.0)  # of the view of a whole world
COSINE, SINE = math.cos(ELEVATION), math.sin(ELEVATION)
MARGIN = 1.04  # factor of its distance
STRAIGHT = 1e-9  # [m] horizontal distance below which a camera looks straight up or down


class NoRendering(Exception):
    """Images cannot be rendered on this machine; the message names the missing software."""


@dataclass(frozen=True)
class Lens:
    """A pinhole camera without distortion."""

    fov: float = math.radians(45.0)  # vertical field of view [rad]
    width: int = 640  # [pixels]
    height: int = 480

    @property
    def aspect(self) -> float:
        """Ratio of width to height."""
        return self.width / self.height


DEFAULT_LENS = Lens()
TEST_LENS = Lens(width=MIN_SIZE, height=MIN_SIZE)  # to find out whether rendering works


@dataclass(frozen=True)
class View:
    """A lens at a pose in `map`, looking along the x axis of its orientation."""

    position: Vector
    orientation: Quaternion
    lens: Lens

    @property
    def axes(self) -> tuple[Array, Array]:
        """Unit vectors forwards and up, in `map`."""
        matrix = rotation_matrix(self.orientation)
        return matrix[:, 0], matrix[:, 2]


def looking_at(position: Vector, target: Vector) -> Quaternion:
    """Return the orientation of an upright camera that looks at a point.

    Straight up or down, the top of the image is towards +y.
    """
    x, y, z = (target[i] - position[i] for i in range(3))
    ground = math.hypot(x, y)
    yaw = math.atan2(y, x) if ground > STRAIGHT else math.pi / 2
    return quaternion(0.0, -math.atan2(z, ground), yaw)


def overview(
    extent: tuple[float, float, float, float], height: float, lens: Lens, others: Sequence[Vector] = ()
) -> View:
    """Return a view of a whole world from the south and above.

    Args:
        extent: Lower x, lower y, upper x, upper y of the world [m].
        height: Height of the world [m].
        lens: The lens.
        others: Further points to include [m].
    """
    left, bottom, right, top = extent
    centre = np.array([(left + right) / 2, (bottom + top) / 2, height / 2])
    back, up = np.array([0.0, -COSINE, SINE]), np.array([0.0, SINE, COSINE])
    corners = np.array([*itertools.product((left, right), (bottom, top), (0.0, height)), *others]) - centre
    nearer = corners @ back
    slope = math.tan(lens.fov / 2)
    # Required distance of a camera on the axis, so that all corners are below, above, and between the edges.
    below = float((corners @ up / slope + nearer).max())
    above = float((-corners @ up / slope + nearer).max())
    between = float((np.abs(corners[:, 0]) / (slope * lens.aspect) + nearer).max())
    distance = MARGIN * max((below + above) / 2, between)
    place = centre + distance * back + (below - above) / 2 * slope * up
    return View(vector(place), quaternion(0.0, ELEVATION, math.pi / 2), lens)


Colour = tuple[float, float, float, float]

SKY: Colour = (0.72, 0.80, 0.88, 1.0)
FLOOR_TILES: tuple[Colour, Colour] = ((0.86, 0.85, 0.82, 1.0), (0.79, 0.78, 0.75, 1.0))
TILE = 1.0  # [m] edge of a floor tile
TERRAIN: Colour = (0.70, 0.66, 0.57, 1.0)
WALL: Colour = (0.42, 0.47, 0.56, 1.0)


@dataclass(frozen=True)
class Light:
    """Light in rendered pictures: the sun, and ambient light from all sides.

    Attributes:
        direction: Direction of the sun's rays in `map`, downwards.
        ambient: Ambient light, relative to the usual.
        diffuse: Light of the sun, relative to the usual.
        brightness: Factor of both.
    """

    direction: Vector = (0.35, 0.5, -1.0)
    ambient: float = 1.0
    diffuse: float = 1.0
    brightness: float = 1.0

    @property
    def sky(self) -> Colour:
        """Colour of the sky in this light."""
        red, green, blue, opacity = SKY
        share = min(self.brightness, 1.0)
        return red * share, green * share, blue * share, opacity


DAYLIGHT = Light()

# Colours of bodies without one, chosen by name.
BODIES: tuple[Colour, ...] = (
    (0.89, 0.47, 0.16, 1.0),
    (0.16, 0.50, 0.73, 1.0),
    (0.24, 0.62, 0.35, 1.0),
    (0.78, 0.22, 0.24, 1.0),
    (0.55, 0.36, 0.67, 1.0),
    (0.90, 0.71, 0.16, 1.0),
)


def colour_of(name: str, own: Colour | None) -> Colour:
    """Return the colour of a body: its own, or one derived from its name, the same in each run."""
    return own if own is not None else BODIES[crc32(name.encode()) % len(BODIES)]
