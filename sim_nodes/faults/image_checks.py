"""Checks of faults of cameras: images are compared pixel by pixel with true ones.

Effects of other faults of the same camera are allowed for: a noisy pixel is never darker than black, and a dead
pixel is not noisy.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import partial
from hashlib import blake2b
from typing import assert_never

import numpy as np

from seoro.bridges import wire
from sim_nodes.faults.checks import (
    Check,
    Checking,
    DelayCheck,
    FreezeCheck,
    MessageLossCheck,
    Observation,
    Pairing,
    SilenceCheck,
)
from sim_nodes.faults.statistics import VALUES, Levels, Tally
from sim_nodes.faults.value_checks import SCANS
from sim_nodes.sensors.camera_pipeline import PERIOD, CameraPipeline, Missing
from sim_nodes.sensors.sensor_pipeline import BRIGHTEST, Sample, brightness_faults
from sim_nodes.views import Picture

NO_PICTURE = "no image has arrived"
ERRORS = np.arange(-BRIGHTEST, BRIGHTEST + 1)

Images = tuple[Sample[Picture], Sample[Picture]]
"""The true and the delivered image of a tick."""


def _images(pipeline: CameraPipeline, tick: int) -> Images | None:
    """Return the images of a tick; None if they are missing or not due."""
    truth = None if tick % PERIOD or pipeline.missing(tick) else pipeline.exposure(tick)
    return None if truth is None else (truth, pipeline.given(truth))


class BrightnessCheck(Check[Images | None]):
    """Checks that the errors of pixels have the deviation of a noise or the mean of a bias.

    Args:
        fault: The fault.
        pipeline: Pipeline of the camera's images.
    """

    STATE = ("_tallies",)

    def __init__(self, fault: wire.GaussianNoise | wire.Bias, pipeline: CameraPipeline) -> None:
        self._fault = fault
        self._pipeline = pipeline
        self._is_noise = isinstance(fault, wire.GaussianNoise)
        # Sums of the errors and, for a noise, of their squares; the last one shows the effect.
        self._tallies = [Tally(VALUES) for _ in range(2 if self._is_noise else 1)]

    def observe(self, seen: Images | None) -> None:
        """See `Check`; counts the errors of the pixels that are not dead."""
        if seen is None:
            return
        faults = self._pipeline.faults
        deviation, offset = brightness_faults({**faults, self._fault.kind: self._fault})
        centre, sound = (offset, Levels(0.0, offset)) if self._is_noise else (0.0, Levels(deviation, 0.0))
        alive = np.ones(seen[0].data.shape[:2], dtype=np.bool_)
        for fault in faults.values():
            if isinstance(fault, wire.DeadPixels | wire.DeadArea):
                alive &= ~self._pipeline.dead(fault)
        truth, given = (image.data[alive].ravel() for image in seen)
        levels = np.bincount(truth, minlength=BRIGHTEST + 1)
        found = np.bincount(given.astype(np.int16) - truth + BRIGHTEST, minlength=len(ERRORS))
        for power, tally in enumerate(self._tallies, 1):
            mean, variance = Levels(deviation, offset).expected(levels, centre, power)
            without, _ = sound.expected(levels, centre, power)
            tally.add(int(found.sum()), float(found @ (ERRORS - centre) ** power), mean, without, variance)

    @property
    def is_confirmed(self) -> bool:
        """Whether the errors fit the fault; those of a noise have the mean of a camera without it."""
        return self._tallies[-1].is_confirmed and self._tallies[0].fits

    def summary(self) -> str:
        """Return a text with the deviation or the mean."""
        tally = self._tallies[-1]
        if tally.count == 0:
            return NO_PICTURE
        figure: Callable[[float], float] = math.sqrt if self._is_noise else float
        found, wanted = (figure(total / tally.count) / BRIGHTEST for total in (tally.found, tally.expected))
        what = "standard deviation" if self._is_noise else "mean"
        errors = f"the errors of {tally.count} values of brightness"
        return f"{errors} have a {what} of {found:.4g}; expected {wanted:.4g}"


class DeadPixelsCheck(Check[Images | None]):
    """Checks that dead pixels are black, and that some would not be without the fault.

    Args:
        fault: The fault.
        pipeline: Pipeline of the camera's images.
    """

    STATE = ("_count", "_pictures", "_blind", "_lit")

    def __init__(self, fault: wire.DeadPixels | wire.DeadArea, pipeline: CameraPipeline) -> None:
        self._fault = fault
        self._pipeline = pipeline
        self._count = 0  # dead pixels of the fault
        self._pictures = 0  # images in a row in which all were black
        self._blind = 0  # black pixels in those images that are not black in truth
        self._lit = 0  # pixels of the last image that should be black, but are not

    def observe(self, seen: Images | None) -> None:
        """See `Check`."""
        if seen is None:
            return
        dead = self._pipeline.dead(self._fault)
        truth, given = (int(image.data[dead].any(axis=1).sum()) for image in seen)
        self._count, self._lit = int(dead.sum()), given
        if self._lit:
            self._pictures = self._blind = 0
        else:
            self._pictures += 1
            self._blind += truth

    @property
    def is_confirmed(self) -> bool:
        """Whether the dead pixels are confirmed."""
        return self._pictures >= SCANS and self._blind > 0

    def summary(self) -> str:
        """Return a text with the numbers."""
        if self._lit:
            return f"{self._lit} of the {self._count} pixels were not black"
        if self._pictures == 0:
            return NO_PICTURE
        return (
            f"in {self._pictures} images all of the {self._count} pixels were black, "
            f"and {self._blind} times one would not have been"
        )


class DelayedImageCheck(DelayCheck):
    """Checks that images show the view of a delay ago."""

    STATE = (*DelayCheck.STATE, "_pairing")

    def __init__(self, fault: wire.Delay) -> None:
        super().__init__(fault, "images", PERIOD)
        self._pairing: Pairing[bytes] = Pairing()

    def observe(self, seen: Observation[bytes]) -> None:
        """See `Check`."""
        super().observe(seen)
        pair = self._pairing.pair(seen)
        if seen.arrived is not None and (pair is None or pair[0] != pair[1]):
            self._late = 0

    def summary(self) -> str:
        """Return a text with the age of the last image."""
        if self._age is None:
            return NO_PICTURE
        return f"the last image was {self._age:.3g} s old, and {self._late} in a row had the expected delay"


def _digest(image: Sample[Picture]) -> Sample[bytes]:
    return Sample(image.tick, blake2b(image.data.tobytes(), digest_size=16).digest())


def _digests(pipeline: CameraPipeline, tick: int) -> Observation[bytes]:
    """Return digests of the images of a tick, the true one with the faults of its pixels."""
    images = _images(pipeline, tick)
    if images is None:
        return Observation(tick, None, None, {})
    return Observation(tick, _digest(pipeline.distorted(images[0])), _digest(images[1]), {})


def _views(pipeline: CameraPipeline, tick: int) -> Observation[bytes]:
    """Return digests of the present view and of the image that is delivered in a tick."""
    view = None if tick % PERIOD else _digest(pipeline.distorted(Sample(tick, pipeline.true_picture())))
    images = _images(pipeline, tick)
    return Observation(tick, view, None if images is None else _digest(images[1]), {})


def arrival(pipeline: CameraPipeline, tick: int) -> Observation[None]:
    """Return the delivery of an image requested in a tick, regardless of its content."""
    missing = pipeline.missing(tick)
    due = None if missing is Missing.DELAYED else Sample(tick, None)
    return Observation(tick, due, None if missing else due, {})


def camera_check(fault: wire.CameraFault, pipeline: CameraPipeline) -> Checking:
    """Return a check of a fault of a camera."""
    images, arrivals = partial(_images, pipeline), partial(arrival, pipeline)
    match fault:
        case wire.GaussianNoise() | wire.Bias():
            return BrightnessCheck(fault, pipeline), images
        case wire.DeadPixels() | wire.DeadArea():
            return DeadPixelsCheck(fault, pipeline), images
        case wire.Freeze():
            return FreezeCheck(operator.eq, "images"), partial(_digests, pipeline)
        case wire.Delay():
            return DelayedImageCheck(fault), partial(_views, pipeline)
        case wire.MessageLoss():
            return MessageLossCheck(fault, "pictures"), arrivals
        case wire.PowerLoss():
            return SilenceCheck("pictures"), arrivals
        case _:
            assert_never(fault)
