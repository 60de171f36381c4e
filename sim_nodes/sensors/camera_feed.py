"""The way of a camera's pictures to those who ask for them, on which faults lie.

A camera takes a picture when it is asked for one. Only one that is late has to have taken it before: as long as it
is, it takes pictures at a rate of its own and keeps them, and what it gives is the newest that is as old as it is
late.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from seoro.bridges.wire import CameraFault, DeadArea, DeadPixels
from sim_nodes.noise import Noise
from sim_nodes.sensors.pixels import Mask, brightness_faults, dead_pixels, with_errors
from sim_nodes.sensors.way import Way
from sim_nodes.views import Lens, Picture

PERIOD = 5  # ticks between two pictures of a camera that is late, or measured


class Missing(Enum):
    """Why there is no picture."""

    NO_POWER = "the camera has no power"
    LOST = "it was lost on its way"
    UNDER_WAY = "it is still on its way, since the camera is late"


@dataclass(frozen=True)
class Exposure:
    """A picture, and the tick in which it was taken."""

    tick: int
    picture: Picture


class CameraFeed(Way[CameraFault, bytes, bytes]):
    """The way of a camera's pictures to those who ask for them.

    Args:
        lens: How it looks.
        look: Takes a picture as a sound camera does.
        noise: Gives the source of the random numbers of a purpose.

    Pictures that it keeps are bytes, which do not change, and so need not be copied with the state. Under way are
    those that are late, by the ticks in which they were taken.
    """

    def __init__(self, lens: Lens, look: Callable[[], Picture], noise: Callable[[str], Noise]) -> None:
        super().__init__(noise)
        self.lens = lens
        self._look = look
        self._noise = noise("gaussian_noise/brightness")
        self._noise_of_pixels = noise("dead_pixels")

    @property
    def is_busy(self) -> bool:
        """Whether it has something to do in every tick."""
        return "delay" in self.faults or ("freeze" in self.faults and self._frozen is None)

    def pass_tick(self, tick: int) -> None:
        """Keep what will be asked for later."""
        if not self._has_power:
            return
        if "delay" in self.faults and tick % PERIOD == 0:
            self._under_way.append((tick, self._look().tobytes()))
            while len(self._under_way) > 1 and self._under_way[1][0] <= tick - self._lateness:
                self._under_way.popleft()
        if "freeze" in self.faults and self._frozen is None:
            seen = self.exposure(tick)
            self._frozen = None if seen is None else self.distorted(seen).tobytes()

    def missing(self, tick: int) -> Missing | None:
        """Why nobody gets a picture in a tick; None if everybody does."""
        if not self._has_power:
            return Missing.NO_POWER
        if self._lateness and self._late_one(tick) is None:
            return Missing.UNDER_WAY
        return Missing.LOST if self._is_lost(tick) else None

    def exposure(self, tick: int) -> Exposure | None:
        """What a camera without faults but for its lateness gives in a tick; None if that has not come."""
        return self._late_one(tick) if self._lateness else Exposure(tick, self._look())

    def sound(self) -> Picture:
        """What a camera without faults gives now."""
        return self._look()

    def _late_one(self, tick: int) -> Exposure | None:
        late_enough = (each for each in reversed(self._under_way) if each[0] <= tick - self._lateness)
        taken, pixels = next(late_enough, (tick, None))
        return None if pixels is None else Exposure(taken, self._picture(pixels))

    def _picture(self, pixels: bytes) -> Picture:
        return np.frombuffer(pixels, dtype=np.uint8).reshape(self.lens.height, self.lens.width, 3)

    def distorted(self, seen: Exposure) -> Picture:
        """A picture with the faults of its pixels."""
        picture, (deviation, offset) = seen.picture, brightness_faults(self.faults)
        if deviation or offset:
            picture = with_errors(picture, deviation, offset, self._noise.at(seen.tick))
        for fault in self.faults.values():
            if isinstance(fault, DeadPixels | DeadArea):
                picture = picture.copy()
                picture[self.dead(fault)] = 0
        return picture

    def dead(self, fault: DeadPixels | DeadArea) -> Mask:
        """The pixels that a fault makes black."""
        return dead_pixels(fault, self.lens.height, self.lens.width, self._noise_of_pixels.at(0))

    def give(self, tick: int) -> Exposure | Missing:
        """What somebody gets who asks for a picture in a tick."""
        missing = self.missing(tick)
        if missing is not None:
            return missing
        seen = self.exposure(tick)
        return Missing.UNDER_WAY if seen is None else self.given(seen)

    def given(self, seen: Exposure) -> Exposure:
        """A picture as it arrives, if it does."""
        frozen = self._frozen
        return Exposure(seen.tick, self.distorted(seen) if frozen is None else self._picture(frozen))
