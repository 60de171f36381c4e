"""Sensors with pixels that measure more than colours: depth and RGB-D cameras, and segmentation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seoro.bridges.wire import Quantity
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, compose_frames
from sim_nodes.noise import Noise
from sim_nodes.outcomes import feature_unsupported
from sim_nodes.physics import FLOOR, Engine
from sim_nodes.robots.sensor_declarations import (
    DepthCameraDeclaration,
    ImagerDeclaration,
    SegmentationDeclaration,
)
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, period_of, within
from sim_nodes.views import TEST_LENS, Lens, NoRendering, Picture, View


class Eye:
    """View of a sensor that is mounted on a link.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the sensor.
        engine: Engine that renders.
    """

    def __init__(self, robot: str, declaration: ImagerDeclaration, engine: Engine) -> None:
        self._robot = robot
        self._declaration = declaration
        self.engine = engine

    def view(self, lens: Lens | None = None) -> View:
        """Return the present view, by default with the lens of the sensor."""
        mount = self._declaration
        link = self.engine.link_pose(self._robot, mount.link)
        position, orientation = compose_frames(link, (mount.position, mount.orientation))
        return View(position, orientation, lens or mount.lens)

    def check(self) -> None:
        """Refuse sensors that cannot be rendered on this machine.

        Raises:
            RequestRefused: The message names the missing software.
        """
        try:
            self.engine.render_depth(self.view(TEST_LENS))
        except NoRendering as error:
            raise feature_unsupported(f"cannot render {self._declaration.name!r}: {error}") from error


@dataclass(frozen=True)
class DepthFrame:
    """One image of a depth camera.

    Attributes:
        depths: Distances along the viewing direction [m], shape (height, width); infinite without a surface.
        picture: Picture of an RGB-D camera; None for a depth camera.
    """

    depths: Array
    picture: Picture | None


class DepthCamera(Sensor[DepthFrame]):
    """A depth or RGB-D camera; its beams are its pixels, by row from the top.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the camera.
        noise: Source of random numbers.
        engine: Engine that renders.
    """

    quantities = (Quantity.LENGTH,)

    def __init__(self, robot: str, declaration: DepthCameraDeclaration, noise: Noise, engine: Engine) -> None:
        self._declaration = declaration
        self._noise = noise
        self._eye = Eye(robot, declaration, engine)
        self.bearings = np.tile(pixel_bearings(declaration.lens), declaration.height)
        self.period = period_of(declaration.rate)
        self.limits = (declaration.min_range, declaration.max_range)
        colours = 3 if declaration.kind == "rgbd_camera" else 0
        self.sample_size = declaration.width * declaration.height * (8 + colours)

    def check(self) -> None:
        """See `Sensor`."""
        self._eye.check()

    def read(self, tick: int) -> DepthFrame:
        """Return an image with the noise of a tick."""
        declaration, random, view = self._declaration, self._noise.at(tick), self._eye.view()
        depths = self._eye.engine.render_depth(view).depths.astype(np.float64)
        if declaration.noise > 0.0 or declaration.noise_growth > 0.0:
            near = np.where(np.isfinite(depths), depths, 0.0)
            deviation = declaration.noise + declaration.noise_growth * near**2
            depths = depths + random.standard_normal(depths.shape) * deviation
        if declaration.dropout > 0.0:
            depths[random.random(depths.shape) < declaration.dropout] = np.inf
        picture = self._eye.engine.render(view) if declaration.kind == "rgbd_camera" else None
        return DepthFrame(within(depths, self.limits), picture)

    def values(self, data: DepthFrame) -> Values:
        """Return the distances of the pixels."""
        return {Quantity.LENGTH: data.depths.ravel()}

    def with_values(self, data: DepthFrame, values: Values) -> DepthFrame:
        """Return the image with other distances."""
        depths = values[Quantity.LENGTH].reshape(data.depths.shape)
        return DepthFrame(within(depths, self.limits), data.picture)


def pixel_bearings(lens: Lens) -> Array:
    """Return the bearing of each column of a picture, to the left from the middle [rad], shape (width,)."""
    focal = lens.height / 2.0 / math.tan(lens.fov / 2.0)  # [pixels]
    bearings: Array = np.arctan((lens.width / 2.0 - 0.5 - np.arange(lens.width)) / focal)
    return bearings


@dataclass(frozen=True)
class SeenBox:
    """Box of an entity in a picture [pixels], without the right column and the lower row, and its pixels."""

    entity: str
    left: int
    top: int
    right: int
    bottom: int
    pixels: int


@dataclass(frozen=True)
class Segments:
    """One image of a segmentation sensor.

    Attributes:
        width: Number of columns.
        height: Number of rows.
        labels: Entity of each pixel by row, as little-endian integers of 16 bits: 0 for nothing, otherwise its
            place in `names`, from 1.
        names: Names of the visible entities, sorted.
        boxes: Boxes of the visible entities except the floor.
    """

    width: int
    height: int
    labels: bytes
    names: tuple[str, ...]
    boxes: tuple[SeenBox, ...]

    def share(self, entity: str) -> float:
        """Return the share of the picture with an entity."""
        return sum(box.pixels for box in self.boxes if box.entity == entity) / (self.width * self.height)


class Segmentation(Sensor[Segments]):
    """An ideal detector: the entity of each pixel.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the sensor.
        engine: Engine that renders.
    """

    def __init__(self, robot: str, declaration: SegmentationDeclaration, engine: Engine) -> None:
        self._declaration = declaration
        self._eye = Eye(robot, declaration, engine)
        self.period = period_of(declaration.rate)
        self.sample_size = declaration.width * declaration.height * 2

    def check(self) -> None:
        """See `Sensor`."""
        self._eye.check()

    def read(self, tick: int) -> Segments:
        """Return the image of a tick."""
        found = self._eye.engine.render_depth(self._eye.view())
        labels, lens = found.entities + 1, self._declaration.lens
        boxes = (_box(labels == number, name) for number, name in enumerate(found.names, 1) if name != FLOOR)
        large = tuple(box for box in boxes if box.pixels >= self._declaration.min_pixels)
        return Segments(lens.width, lens.height, labels.astype("<u2").tobytes(), found.names, large)


def _box(mask: NDArray[np.bool_], entity: str) -> SeenBox:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, right, top, bottom = (int(each) for each in (columns[0], columns[-1], rows[0], rows[-1]))
    return SeenBox(entity, left, top, right + 1, bottom + 1, int(mask.sum()))
