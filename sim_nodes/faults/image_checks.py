"""Checks of faults of cameras: images are compared pixel by pixel with true ones.

Effects of other faults of the same camera are allowed for: a noisy pixel is never darker than black, and a dead
pixel is not noisy.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from hashlib import blake2b
from typing import assert_never

import numpy as np

from seoro.bridges import wire
from sim_nodes.faults.checks import IN_A_ROW, Check, Checking, MessageLossCheck, Observation, SilenceCheck
from sim_nodes.faults.statistics import VALUES, Counts, Levels, Tally
from sim_nodes.faults.value_checks import SCANS
from sim_nodes.sensors.camera_pipeline import PERIOD, CameraPipeline, Exposure, Missing
from sim_nodes.sensors.sensor_pipeline import BRIGHTEST, Sample, brightness_faults
from sim_nodes.ticks import TICK
from sim_nodes.views import Picture

NO_PICTURE = "no image has arrived"
ROUNDING = 1e-9


@dataclass(frozen=True)
class ImageRequest:
    """A request for an image of a camera in a tick."""

    pipeline: CameraPipeline
    tick: int


class ImageCheck(Check[ImageRequest]):
    """A check of a fault of a camera by its images."""

    def observe(self, seen: ImageRequest) -> None:
        """See `Check`; images that are missing or not due are ignored."""
        pipeline, tick = seen.pipeline, seen.tick
        if tick % PERIOD or pipeline.missing(tick):
            return
        truth = pipeline.exposure(tick)
        if truth is not None:
            self.compare(seen, truth, pipeline.given(truth))

    @abstractmethod
    def compare(self, seen: ImageRequest, truth: Exposure, given: Exposure) -> None:
        """Update with the true and the delivered image."""


ERRORS = np.arange(-BRIGHTEST, BRIGHTEST + 1)


@dataclass(frozen=True)
class Errors:
    """Histogram of the errors of pixels that are not dead.

    Args:
        levels: Number of true values of each level, shape (256,).
        found: Number of errors from -255 to 255 levels, shape (511,).
    """

    levels: Counts
    found: Counts

    @classmethod
    def of(cls, pipeline: CameraPipeline, truth: Picture, given: Picture) -> Errors:
        """Return the errors of an image."""
        alive = np.ones(truth.shape[:2], dtype=np.bool_)
        for fault in pipeline.faults.values():
            if isinstance(fault, wire.DeadPixels | wire.DeadArea):
                alive &= ~pipeline.dead(fault)
        true_picture = truth[alive].ravel()
        off = given[alive].ravel().astype(np.int16) - true_picture
        found = np.bincount(off + BRIGHTEST, minlength=len(ERRORS))
        return cls(np.bincount(true_picture, minlength=BRIGHTEST + 1), found)

    def add_to(self, tally: Tally, centre: float, power: int, faulty: Levels, true_picture: Levels) -> None:
        """Add a power of the errors about a value, with its expectations with and without the fault."""
        mean, variance = faulty.expected(self.levels, centre, power)
        sound, _ = true_picture.expected(self.levels, centre, power)
        found = float(self.found @ (ERRORS - centre) ** power)
        tally.add(int(self.found.sum()), found, mean, sound, variance)


class BrightnessCheck(ImageCheck):
    """Checks that the errors of pixels are those of a noise or a bias."""

    def __init__(self, fault: wire.GaussianNoise | wire.Bias) -> None:
        self._fault = fault

    def compare(self, seen: ImageRequest, truth: Exposure, given: Exposure) -> None:
        """See `ImageCheck`."""
        errors = Errors.of(seen.pipeline, truth.picture, given.picture)
        self.count(errors, *brightness_faults({**seen.pipeline.faults, self._fault.kind: self._fault}))

    @abstractmethod
    def count(self, errors: Errors, deviation: float, offset: float) -> None:
        """Add the errors of an image; with the fault they have this deviation and offset [levels]."""


def _figures(tally: Tally, what: str, figure: Callable[[float], float]) -> str:
    """Return a text for a statistic; `figure` computes it from the mean of the tally [levels]."""
    if tally.count == 0:
        return NO_PICTURE
    found, wanted = (figure(total / tally.count) / BRIGHTEST for total in (tally.found, tally.expected))
    errors = f"the errors of {tally.count} values of brightness"
    return f"{errors} have a {what} of {found:.4g}; expected {wanted:.4g}"


class PixelNoiseCheck(BrightnessCheck):
    """Checks that the errors of pixels have the deviation of a noise."""

    STATE = ("_sums", "_squares")

    def __init__(self, fault: wire.GaussianNoise) -> None:
        super().__init__(fault)
        self._sums = Tally(VALUES)
        self._squares = Tally(VALUES)

    def count(self, errors: Errors, deviation: float, offset: float) -> None:
        """See `BrightnessCheck`."""
        faulty, true_picture = Levels(deviation, offset), Levels(0.0, offset)
        errors.add_to(self._sums, offset, 1, faulty, true_picture)
        errors.add_to(self._squares, offset, 2, faulty, true_picture)

    @property
    def is_confirmed(self) -> bool:
        """Whether the deviation fits the fault, and the mean fits a camera without it."""
        return self._squares.is_confirmed and self._sums.fits

    def summary(self) -> str:
        """Return a text with the deviation."""
        return _figures(self._squares, "standard deviation", math.sqrt)


class PixelBiasCheck(BrightnessCheck):
    """Checks that the errors of pixels have the mean of a bias."""

    STATE = ("_sum",)

    def __init__(self, fault: wire.Bias) -> None:
        super().__init__(fault)
        self._sum = Tally(VALUES)

    def count(self, errors: Errors, deviation: float, offset: float) -> None:
        """See `BrightnessCheck`."""
        errors.add_to(self._sum, 0.0, 1, Levels(deviation, offset), Levels(deviation, 0.0))

    @property
    def is_confirmed(self) -> bool:
        """Whether the mean fits the fault."""
        return self._sum.is_confirmed

    def summary(self) -> str:
        """Return a text with the mean."""
        return _figures(self._sum, "mean", float)


class DeadPixelsCheck(ImageCheck):
    """Checks that dead pixels are black, and that some would not be without the fault."""

    STATE = ("_count", "_pictures", "_blind", "_lit")

    def __init__(self, fault: wire.DeadPixels | wire.DeadArea) -> None:
        self._fault = fault
        self._count = 0  # dead pixels of the fault
        self._pictures = 0  # images in a row in which all were black
        self._blind = 0  # black pixels in those images that are not black in truth
        self._lit = 0  # pixels of the last image that should be black, but are not

    def compare(self, seen: ImageRequest, truth: Exposure, given: Exposure) -> None:
        """See `ImageCheck`."""
        dead = seen.pipeline.dead(self._fault)
        self._count = int(dead.sum())
        self._lit = int(given.picture[dead].any(axis=1).sum())
        if self._lit:
            self._pictures = self._blind = 0
        else:
            self._pictures += 1
            self._blind += int(truth.picture[dead].any(axis=1).sum())

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


class FrozenImageCheck(ImageCheck):
    """Checks that images repeat although the view changes."""

    STATE = ("_last", "_same")

    def __init__(self) -> None:
        self._last = b""  # digest of the last image
        self._same = 0  # repeated images in a row that should differ

    def compare(self, seen: ImageRequest, truth: Exposure, given: Exposure) -> None:
        """See `ImageCheck`."""
        last, self._last = self._last, _digest(given.picture)
        if last != self._last:
            self._same = 0
        elif _digest(seen.pipeline.distorted(truth)) != self._last:
            self._same += 1

    @property
    def is_confirmed(self) -> bool:
        """Whether the images are frozen."""
        return self._same >= IN_A_ROW

    def summary(self) -> str:
        """Return a text with the number of repetitions."""
        return f"{self._same} images in a row repeated the one before, although the true ones differ"


class DelayedImageCheck(ImageCheck):
    """Checks that images show the view of a delay ago."""

    STATE = ("_seen", "_late", "_age")

    def __init__(self, fault: wire.Delay) -> None:
        self._delay = fault.time
        self._seen: dict[int, bytes] = {}  # digests of the true views by tick
        self._late = 0  # delayed images in a row
        self._age: float | None = None  # of the last image [s]

    def observe(self, seen: ImageRequest) -> None:
        """See `Check`."""
        if seen.tick % PERIOD == 0:
            exposure = Exposure(seen.tick, seen.pipeline.true_picture())
            self._seen[seen.tick] = _digest(seen.pipeline.distorted(exposure))
        super().observe(seen)

    def compare(self, seen: ImageRequest, truth: Exposure, given: Exposure) -> None:
        """See `ImageCheck`."""
        self._age = (seen.tick - given.tick) * TICK
        is_late = -ROUNDING <= self._age - self._delay < PERIOD * TICK
        is_of_then = self._seen.get(given.tick) == _digest(given.picture)
        self._late = self._late + 1 if is_late and is_of_then else 0
        self._seen = {when: digest for when, digest in self._seen.items() if when >= given.tick}

    @property
    def is_confirmed(self) -> bool:
        """Whether the images are delayed as expected."""
        return self._late >= IN_A_ROW

    def summary(self) -> str:
        """Return a text with the age of the last image."""
        if self._age is None:
            return NO_PICTURE
        return f"the last image was {self._age:.3g} s old, and {self._late} in a row had the expected delay"


def arrival(pipeline: CameraPipeline, tick: int) -> Observation[None]:
    """Return the delivery of an image requested in a tick, regardless of its content."""
    missing = pipeline.missing(tick)
    due = None if missing is Missing.DELAYED else Sample(tick, None)
    return Observation(tick, due, None if missing else due, {})


def _digest(picture: Picture) -> bytes:
    return blake2b(picture.tobytes(), digest_size=16).digest()


def camera_check(fault: wire.CameraFault, pipeline: CameraPipeline) -> Checking:
    """Return a check of a fault of a camera."""
    requests, arrivals = partial(ImageRequest, pipeline), partial(arrival, pipeline)
    match fault:
        case wire.GaussianNoise():
            return PixelNoiseCheck(fault), requests
        case wire.Bias():
            return PixelBiasCheck(fault), requests
        case wire.DeadPixels() | wire.DeadArea():
            return DeadPixelsCheck(fault), requests
        case wire.Freeze():
            return FrozenImageCheck(), requests
        case wire.Delay():
            return DelayedImageCheck(fault), requests
        case wire.MessageLoss():
            return MessageLossCheck(fault, "pictures"), arrivals
        case wire.PowerLoss():
            return SilenceCheck("pictures"), arrivals
        case _:
            assert_never(fault)
