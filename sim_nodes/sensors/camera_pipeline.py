"""The pipeline of a camera's images, with faults.

A camera renders on request. Only for a delay, it renders at a rate of its own and keeps the images; a client gets
the newest one that is old enough.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

import numpy as np

from seoro.bridges.wire import CameraFault, DeadArea, DeadPixels
from sim_nodes.noise import Noise
from sim_nodes.sensors.sensor_pipeline import DelayLine, Mask, Sample, brightness_faults, dead_pixels, with_errors
from sim_nodes.views import Lens, Picture

PERIOD = 5  # ticks between two images of a delayed or checked camera


class Missing(Enum):
    """Reasons for a missing image."""

    NO_POWER = "the camera has no power"
    LOST = "the image was lost"
    DELAYED = "the image is delayed"


class CameraPipeline(DelayLine[CameraFault, bytes, bytes]):
    """The pipeline of a camera's images to clients.

    Args:
        lens: Lens of the camera.
        look: Renders a true image.
        noise: Factory of noise sources by purpose.

    Kept images are bytes, which are immutable and need no copy with the state. `_in_transit` has delayed images by
    the tick of their rendering.

    Attributes:
        true_picture: Renders a true image.
    """

    def __init__(self, lens: Lens, look: Callable[[], Picture], noise: Callable[[str], Noise]) -> None:
        super().__init__(noise)
        self.lens = lens
        self.true_picture = look
        self._noise = noise("gaussian_noise/brightness")
        self._noise_of_pixels = noise("dead_pixels")

    @property
    def is_busy(self) -> bool:
        """Whether it needs every tick."""
        return "delay" in self.faults or ("freeze" in self.faults and self._frozen is None)

    def update(self, tick: int) -> None:
        """Keep an image for later requests."""
        if not self._has_power:
            return
        if "delay" in self.faults and tick % PERIOD == 0:
            self._in_transit.append((tick, self.true_picture().tobytes()))
            while len(self._in_transit) > 1 and self._in_transit[1][0] <= tick - self._delay_ticks:
                self._in_transit.popleft()
        if "freeze" in self.faults and self._frozen is None:
            seen = self.exposure(tick)
            self._frozen = None if seen is None else self.distorted(seen).data.tobytes()

    def missing(self, tick: int) -> Missing | None:
        """Return why clients get no image in a tick; None if they get one."""
        if not self._has_power:
            return Missing.NO_POWER
        if self._delay_ticks and self._delayed_exposure(tick) is None:
            return Missing.DELAYED
        return Missing.LOST if self._is_lost(tick) else None

    def exposure(self, tick: int) -> Sample[Picture] | None:
        """Return the delayed image of a tick without other faults; None if none has arrived."""
        return self._delayed_exposure(tick) if self._delay_ticks else Sample(tick, self.true_picture())

    def _delayed_exposure(self, tick: int) -> Sample[Picture] | None:
        late_enough = (each for each in reversed(self._in_transit) if each[0] <= tick - self._delay_ticks)
        taken, pixels = next(late_enough, (tick, None))
        return None if pixels is None else Sample(taken, self._picture(pixels))

    def _picture(self, pixels: bytes) -> Picture:
        return np.frombuffer(pixels, dtype=np.uint8).reshape(self.lens.height, self.lens.width, 3)

    def distorted(self, seen: Sample[Picture]) -> Sample[Picture]:
        """Return an image with pixel faults."""
        picture, (deviation, offset) = seen.data, brightness_faults(self.faults)
        if deviation or offset:
            picture = with_errors(picture, deviation, offset, self._noise.at(seen.tick))
        for fault in self.faults.values():
            if isinstance(fault, DeadPixels | DeadArea):
                picture = picture.copy()
                picture[self.dead(fault)] = 0
        return Sample(seen.tick, picture)

    def dead(self, fault: DeadPixels | DeadArea) -> Mask:
        """Return the pixels that a fault makes black."""
        return dead_pixels(fault, self.lens.height, self.lens.width, self._noise_of_pixels.at(0))

    def give(self, tick: int) -> Sample[Picture] | Missing:
        """Return what a client gets in a tick."""
        missing = self.missing(tick)
        if missing is not None:
            return missing
        seen = self.exposure(tick)
        return Missing.DELAYED if seen is None else self.given(seen)

    def given(self, seen: Sample[Picture]) -> Sample[Picture]:
        """Return an image as delivered."""
        frozen = self._frozen
        return self.distorted(seen) if frozen is None else Sample(seen.tick, self._picture(frozen))
