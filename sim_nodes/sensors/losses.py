"""Effects of faults on beams and pixels.

Brightness has 256 levels; faults are declared as shares of the brightest. Values with errors are rounded to a
level, and clipped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    CameraFault,
    DeadArea,
    DeadBeams,
    DeadPixels,
    DeadSector,
    GaussianNoise,
    Quantity,
)
from sim_nodes.geometry import Array
from sim_nodes.views import Picture

Beams = NDArray[np.intp]
BeamFault = BeamLoss | DeadSector | DeadBeams


def blind_beams(fault: BeamFault, bearings: Array, random: np.random.Generator) -> Beams:
    """Return the indices of the beams that a fault makes blind in a scan; `random` belongs to the scan."""
    match fault:
        case BeamLoss(share=share):
            return random.choice(len(bearings), lost_beams(share, len(bearings)), replace=False)
        case DeadSector() | DeadBeams():
            return dead_beams(fault, bearings)
        case _:
            assert_never(fault)


def lost_beams(share: float, count: int) -> int:
    """Return the number of beams for a share; 0.29 of 100 are 29, despite the rounding of floats."""
    return int(share * count + 1e-9)


def dead_beams(fault: DeadSector | DeadBeams, bearings: Array) -> Beams:
    """Return the indices of the beams that a fault makes blind in every scan."""
    match fault:
        case DeadSector(start=start, end=end):
            turn = 2.0 * math.pi
            width = (end - start) % turn or turn  # a sector that ends where it starts is the full circle
            return np.flatnonzero((bearings - start) % turn <= width)
        case DeadBeams(beams=beams):
            return np.array(beams, dtype=np.intp)
        case _:
            assert_never(fault)


BRIGHTEST = 255

Mask = NDArray[np.bool_]
"""Pixels of an image, shape (height, width)."""


def brightness_faults(faults: Mapping[str, CameraFault]) -> tuple[float, float]:
    """Return the standard deviation and the offset of the errors of a camera's values [levels]."""
    noise, bias = faults.get("gaussian_noise"), faults.get("bias")
    deviation = noise.deviation.get(Quantity.BRIGHTNESS, 0.0) if isinstance(noise, GaussianNoise) else 0.0
    offset = bias.offset.get(Quantity.BRIGHTNESS, 0.0) if isinstance(bias, Bias) else 0.0
    return deviation * BRIGHTEST, offset * BRIGHTEST


def with_errors(picture: Picture, deviation: float, offset: float, random: np.random.Generator) -> Picture:
    """Return an image with an offset and normally distributed errors [levels]."""
    values = picture.astype(np.float32) + np.float32(offset)
    if deviation > 0.0:
        values += random.standard_normal(picture.shape, dtype=np.float32) * np.float32(deviation)
    levels: Picture = np.clip(np.rint(values), 0, BRIGHTEST).astype(np.uint8)
    return levels


def dead_pixels(fault: DeadPixels | DeadArea, height: int, width: int, random: np.random.Generator) -> Mask:
    """Return the pixels that a fault makes black; `random` is the same for all images of a camera."""
    match fault:
        case DeadPixels(share=share):
            mask = np.zeros(height * width, dtype=np.bool_)
            mask[random.choice(len(mask), lost_beams(share, len(mask)), replace=False)] = True
            return mask.reshape(height, width)
        case DeadArea(left=left, top=top, right=right, bottom=bottom):
            # A pixel belongs to an area by its centre.
            across, down = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
            rows, columns = (down >= top) & (down <= bottom), (across >= left) & (across <= right)
            return rows[:, None] & columns[None, :]
        case _:
            assert_never(fault)
