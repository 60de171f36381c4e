"""Video of a simulation: images at equal steps of simulated time, as an MP4 that is playable up to its end.

It is fragmented: its header is followed by pieces of a second each, so that the recording of a killed run is
playable. The pieces are kept until they are collected, not written.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from sim_nodes.ticks import TICK
from sim_nodes.views import Picture

RATES = (1, 2, 5, 10, 25, 50)  # [Hz]; images are taken in ticks
MAX_KEPT = 32 * 1024 * 1024  # [bytes] of a video that is not collected; about an hour
QUALITY = "23"  # x264's constant rate factor; lower is better, 23 is the default
FLAGS = "frag_keyframe+empty_moov+default_base_moof"

log = logging.getLogger(__name__)


class NoVideo(Exception):
    """Videos cannot be encoded on this machine; the message names the missing software."""


class _Collected:
    """Collects the output of a container, in place of a file for PyAV."""

    def __init__(self) -> None:
        self._data = bytearray()

    def write(self, data: bytes) -> int:
        """Append output; called by PyAV."""
        if len(self._data) > MAX_KEPT:
            raise OSError(f"the last {MAX_KEPT} bytes of the video were not collected")
        self._data += data
        return len(data)

    def drain(self) -> bytes:
        """Return the output since the last call."""
        data = bytes(self._data)
        self._data.clear()
        return data


class Encoder:
    """H.264 in MP4.

    Args:
        width: Width of images [pixels], even.
        height: Height of images [pixels], even.
        rate: Images per second [Hz].

    Raises:
        NoVideo: The encoder is missing.
    """

    def __init__(self, width: int, height: int, rate: int) -> None:
        try:
            import av  # noqa: PLC0415 - optional, and large
        except ImportError as error:
            raise NoVideo("videos need PyAV: pip install 'seoro[video]'") from error
        self._av: Any = av
        self._collected = _Collected()
        self._container = av.open(self._collected, "w", format="mp4", options={"movflags": FLAGS})
        # Without lookahead, the video of a killed run ends at most a second early.
        options = {"preset": "veryfast", "crf": QUALITY, "tune": "zerolatency"}
        self._stream = self._container.add_stream("libx264", rate=rate, options=options)
        self._stream.width, self._stream.height, self._stream.pix_fmt = width, height, "yuv420p"
        self._stream.gop_size = rate  # a fragment per second
        self._stream.thread_count = 1  # one processor is for the simulation
        self._time_base = Fraction(1, rate)
        self._count = 0

    def add(self, picture: Picture) -> None:
        """Add the next image."""
        frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
        frame.pts, frame.time_base = self._count, self._time_base
        self._count += 1
        self._container.mux(self._stream.encode(frame))

    def finish(self) -> None:
        """Complete the file."""
        self._container.mux(self._stream.encode(None))
        self._container.close()

    def drain(self) -> bytes:
        """Return the part of the file since the last call."""
        return self._collected.drain()


class Recorder:
    """Takes an image whenever one is due.

    An error ends the recording, not the simulation; it is reported with the rest of the file.

    Args:
        look: Renders an image.
        encoder: Encodes the video.
        rate: Images per second of simulated time [Hz], one of `RATES`.
    """

    def __init__(self, look: Callable[[], Picture], encoder: Encoder, rate: int) -> None:
        self._look = look
        self._encoder = encoder
        self._every = round(1.0 / rate / TICK)
        self._ticks = 0
        self.error = ""

    def tick(self) -> None:
        """Update with a tick, also once at the start."""
        if self._ticks % self._every == 0:
            self._guard(lambda: self._encoder.add(self._look()))
        self._ticks += 1

    def finish(self) -> None:
        """Complete the video."""
        self._guard(self._encoder.finish)

    def drain(self) -> bytes:
        """Return the part of the file since the last call."""
        return self._encoder.drain()

    def _guard(self, act: Callable[[], None]) -> None:
        if self.error:
            return
        try:
            act()
        except Exception as error:  # of the encoder, the renderer, or the view
            log.exception("error while recording")
            self.error = f"{type(error).__name__}: {error}"
