"""Measuring faults of cameras: what they give is compared, pixel by pixel, with what sound ones would give.

What other faults of the same camera do to its pixels is allowed for: a noisy pixel is never darker than black, and
a dead one is not noisy.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import blake2b
from typing import assert_never

import numpy as np

from seoro.bridges.wire import (
    Bias,
    CameraFault,
    DeadArea,
    DeadPixels,
    Delay,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
)
from sim_nodes.faults.arrivals import IN_A_ROW, MessageLossCheck, SilenceCheck
from sim_nodes.faults.check import Check, Observation, SensorCheck
from sim_nodes.faults.levels import Counts, Levels
from sim_nodes.faults.tally import VALUES, Tally
from sim_nodes.faults.values import SCANS
from sim_nodes.sensors.camera_feed import PERIOD, CameraFeed, Exposure, Missing
from sim_nodes.sensors.pixels import BRIGHTEST, brightness_faults
from sim_nodes.sensors.sensor import Sample
from sim_nodes.ticks import TICK
from sim_nodes.views import Picture

NO_PICTURE = "no picture has arrived"
ROUNDING = 1e-9


class CameraCheck(Check):
    """A measurement of a fault of a camera, by pictures that it gives."""

    @abstractmethod
    def observe(self, feed: CameraFeed, tick: int) -> None:
        """Take in a tick."""


def _pictures(feed: CameraFeed, tick: int) -> tuple[Exposure, Exposure] | None:
    """A picture as it was taken, and as it is given; None where there is none, or none is due."""
    if tick % PERIOD or feed.missing(tick):
        return None
    seen = feed.exposure(tick)
    return None if seen is None else (seen, feed.given(seen))


ERRORS = np.arange(-BRIGHTEST, BRIGHTEST + 1)


@dataclass(frozen=True)
class Errors:
    """The errors of the pixels that are not dead, counted.

    Args:
        levels: How many of the values have each level in truth, shape (256,).
        found: How many have each error, from -255 to 255 levels, shape (511,).
    """

    levels: Counts
    found: Counts

    @classmethod
    def of(cls, feed: CameraFeed, truth: Picture, given: Picture) -> Errors:
        """Those of a picture."""
        alive = np.ones(truth.shape[:2], dtype=np.bool_)
        for fault in feed.faults.values():
            if isinstance(fault, DeadPixels | DeadArea):
                alive &= ~feed.dead(fault)
        sound = truth[alive].ravel()
        off = given[alive].ravel().astype(np.int16) - sound
        found = np.bincount(off + BRIGHTEST, minlength=len(ERRORS))
        return cls(np.bincount(sound, minlength=BRIGHTEST + 1), found)

    def add_to(self, tally: Tally, centre: float, power: int, faulty: Levels, sound: Levels) -> None:
        """Count a power of the errors about a value as it is, and as it should be with a fault and without it."""
        expected = faulty.expected(self.levels, centre, power)
        without = sound.expected(self.levels, centre, power)
        found = float(self.found @ (ERRORS - centre) ** power)
        tally.add(int(self.found.sum()), found, expected.mean, without.mean, expected.variance)


class BrightnessCheck(CameraCheck):
    """Whether the errors of pixels are those of a noise or a bias."""

    def __init__(self, fault: GaussianNoise | Bias) -> None:
        self._fault = fault

    def observe(self, feed: CameraFeed, tick: int) -> None:
        """Take in a tick."""
        pictures = _pictures(feed, tick)
        if pictures is not None:
            seen, given = pictures
            errors = Errors.of(feed, seen.picture, given.picture)
            self.count(errors, *brightness_faults({**feed.faults, self._fault.kind: self._fault}))

    @abstractmethod
    def count(self, errors: Errors, deviation: float, offset: float) -> None:
        """Count the errors of a picture; with the fault they have a deviation and are off [levels]."""


def _figures(tally: Tally, what: str, figure: Callable[[float], float]) -> str:
    """What has been counted, in words: a figure of the mean of what was tallied [levels]."""
    if tally.count == 0:
        return NO_PICTURE
    found, wanted = (figure(total / tally.count) / BRIGHTEST for total in (tally.found, tally.expected))
    errors = f"the errors of {tally.count} values of brightness"
    return f"{errors} have a {what} of {found:.4g}, expected were {wanted:.4g}"


class PixelNoiseCheck(BrightnessCheck):
    """Whether the errors of pixels have the deviation of a noise."""

    STATE = ("_sums", "_squares")

    def __init__(self, fault: GaussianNoise) -> None:
        super().__init__(fault)
        self._sums = Tally(VALUES)
        self._squares = Tally(VALUES)

    def count(self, errors: Errors, deviation: float, offset: float) -> None:
        """See `BrightnessCheck`."""
        faulty, sound = Levels(deviation, offset), Levels(0.0, offset)
        errors.add_to(self._sums, offset, 1, faulty, sound)
        errors.add_to(self._squares, offset, 2, faulty, sound)

    @property
    def holds(self) -> bool:
        """Whether the deviation is that of the fault, about no other mean than there would be without it."""
        return self._squares.holds and self._sums.fits

    def figures(self) -> str:
        """The deviation."""
        return _figures(self._squares, "standard deviation", math.sqrt)


class PixelBiasCheck(BrightnessCheck):
    """Whether the errors of pixels have the mean of a bias."""

    STATE = ("_sum",)

    def __init__(self, fault: Bias) -> None:
        super().__init__(fault)
        self._sum = Tally(VALUES)

    def count(self, errors: Errors, deviation: float, offset: float) -> None:
        """See `BrightnessCheck`."""
        errors.add_to(self._sum, 0.0, 1, Levels(deviation, offset), Levels(deviation, 0.0))

    @property
    def holds(self) -> bool:
        """Whether the mean is that of the fault."""
        return self._sum.holds

    def figures(self) -> str:
        """The mean."""
        return _figures(self._sum, "mean", float)


class DeadPixelsCheck(CameraCheck):
    """Whether pixels are black, and some of them should not be."""

    STATE = ("_count", "_pictures", "_blind", "_lit")

    def __init__(self, fault: DeadPixels | DeadArea) -> None:
        self._fault = fault
        self._count = 0  # pixels that are to be dead
        self._pictures = 0  # in a row in which they were black
        self._blind = 0  # pixels that were black in those, and should not have been
        self._lit = 0  # pixels in the last picture that should have been black, and were not

    def observe(self, feed: CameraFeed, tick: int) -> None:
        """Take in a tick."""
        pictures = _pictures(feed, tick)
        if pictures is None:
            return
        seen, given = pictures
        dead = feed.dead(self._fault)
        self._count = int(dead.sum())
        self._lit = int(given.picture[dead].any(axis=1).sum())
        if self._lit:
            self._pictures = self._blind = 0
        else:
            self._pictures += 1
            self._blind += int(seen.picture[dead].any(axis=1).sum())

    @property
    def holds(self) -> bool:
        """Whether they are."""
        return self._pictures >= SCANS and self._blind > 0

    def figures(self) -> str:
        """How many."""
        if self._lit:
            return f"{self._lit} of the {self._count} pixels were not black"
        if self._pictures == 0:
            return NO_PICTURE
        return (
            f"in {self._pictures} pictures all of the {self._count} pixels were black, "
            f"and {self._blind} times one would not have been"
        )


class StandingPictureCheck(CameraCheck):
    """Whether pictures are the same, though what a camera sees is not."""

    STATE = ("_last", "_same")

    def __init__(self) -> None:
        self._last = b""  # digest of the last picture
        self._same = 0  # pictures in a row that are like those before, and should not be

    def observe(self, feed: CameraFeed, tick: int) -> None:
        """Take in a tick."""
        pictures = _pictures(feed, tick)
        if pictures is None:
            return
        seen, given = pictures
        last, self._last = self._last, _digest(given.picture)
        if last != self._last:
            self._same = 0
        elif _digest(feed.distorted(seen)) != self._last:
            self._same += 1

    @property
    def holds(self) -> bool:
        """Whether they are."""
        return self._same >= IN_A_ROW

    def figures(self) -> str:
        """How many."""
        return f"{self._same} pictures in a row were as the one before, where a sound camera's would have differed"


class LatePictureCheck(CameraCheck):
    """Whether pictures show what there was to be seen a delay before."""

    STATE = ("_seen", "_late", "_age")

    def __init__(self, fault: Delay) -> None:
        self._delay = fault.time
        self._seen: dict[int, bytes] = {}  # digests of what was to be seen, by tick
        self._late = 0  # pictures in a row
        self._age: float | None = None  # of the last one [s]

    def observe(self, feed: CameraFeed, tick: int) -> None:
        """Take in a tick."""
        if tick % PERIOD == 0:
            self._seen[tick] = _digest(feed.distorted(Exposure(tick, feed.sound())))
        pictures = _pictures(feed, tick)
        if pictures is None:
            return
        _, given = pictures
        self._age = (tick - given.tick) * TICK
        is_late = -ROUNDING <= self._age - self._delay < PERIOD * TICK
        is_of_then = self._seen.get(given.tick) == _digest(given.picture)
        self._late = self._late + 1 if is_late and is_of_then else 0
        self._seen = {when: digest for when, digest in self._seen.items() if when >= given.tick}

    @property
    def holds(self) -> bool:
        """Whether they do."""
        return self._late >= IN_A_ROW

    def figures(self) -> str:
        """How old the last one was."""
        if self._age is None:
            return NO_PICTURE
        return (
            f"the last picture was {self._age:.3g} s old, and {self._late} in a row showed what there was to be "
            "seen as long ago as they should"
        )


def arrival(feed: CameraFeed, tick: int) -> Observation[None]:
    """What there would be of a picture that somebody asks for in a tick, whatever is to be seen on it."""
    missing = feed.missing(tick)
    due = None if missing is Missing.UNDER_WAY else Sample(tick, None)
    return Observation(tick, due, None if missing else due, {})


def measure(check: Check, feed: CameraFeed, tick: int) -> None:
    """Let a measurement that `camera_check` has begun take in a tick."""
    if isinstance(check, CameraCheck):
        check.observe(feed, tick)
    else:
        assert isinstance(check, SensorCheck)
        check.observe(arrival(feed, tick))


def _digest(picture: Picture) -> bytes:
    return blake2b(picture.tobytes(), digest_size=16).digest()


def camera_check(fault: CameraFault) -> CameraCheck | SensorCheck:
    """The measurement of a fault of a camera."""
    match fault:
        case GaussianNoise():
            return PixelNoiseCheck(fault)
        case Bias():
            return PixelBiasCheck(fault)
        case DeadPixels() | DeadArea():
            return DeadPixelsCheck(fault)
        case Freeze():
            return StandingPictureCheck()
        case Delay():
            return LatePictureCheck(fault)
        case MessageLoss():
            return MessageLossCheck(fault, "pictures")
        case PowerLoss():
            return SilenceCheck("pictures")
        case _:
            assert_never(fault)
