"""Films of a simulation: pictures at equal steps of simulated time, as an MP4 that plays as far as it goes.

It is fragmented: after its head come pieces of a second each, so that what was recorded of a run that is killed
plays, too. Nothing is written here: the pieces are kept until they are collected.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from sim_nodes.ticks import TICK
from sim_nodes.views import Picture

RATES = (1, 2, 5, 10, 25, 50)  # [Hz]; pictures are taken in ticks
MAX_KEPT = 32 * 1024 * 1024  # [bytes] of a film that nobody collects; an hour or so
QUALITY = "23"  # x264's constant rate factor, for which smaller is better; 23 is its default
FLAGS = "frag_keyframe+empty_moov+default_base_moof"

log = logging.getLogger(__name__)


class NoVideo(Exception):
    """Films cannot be made on this machine; the message says what is missing."""


class _Collected:
    """What a container has written, where PyAV expects a file."""

    def __init__(self) -> None:
        self._data = bytearray()

    def write(self, data: bytes) -> int:
        """Called by PyAV."""
        if len(self._data) > MAX_KEPT:
            raise OSError(f"nobody has collected the last {MAX_KEPT} bytes of it")
        self._data += data
        return len(data)

    def take(self) -> bytes:
        """What was written since this was last called."""
        data = bytes(self._data)
        self._data.clear()
        return data


class Encoder:
    """H.264 in MP4.

    Args:
        width: Of pictures [pixels], even.
        height: The same.
        rate: Pictures per second [Hz].

    Raises:
        NoVideo: There is no encoder.
    """

    def __init__(self, width: int, height: int, rate: int) -> None:
        try:
            import av  # noqa: PLC0415 - optional, and large
        except ImportError as error:
            raise NoVideo("films need PyAV: pip install 'seoro[video]'") from error
        self._av: Any = av
        self._collected = _Collected()
        self._container = av.open(self._collected, "w", format="mp4", options={"movflags": FLAGS})
        # Without looking ahead, what a killed run leaves ends a second before that at most.
        options = {"preset": "veryfast", "crf": QUALITY, "tune": "zerolatency"}
        self._stream = self._container.add_stream("libx264", rate=rate, options=options)
        self._stream.width, self._stream.height, self._stream.pix_fmt = width, height, "yuv420p"
        self._stream.gop_size = rate  # a fragment for each second
        self._stream.thread_count = 1  # one processor is the simulation's
        self._time_base = Fraction(1, rate)
        self._count = 0

    def add(self, picture: Picture) -> None:
        """Add a picture, which is shown after the one before."""
        frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
        frame.pts, frame.time_base = self._count, self._time_base
        self._count += 1
        self._container.mux(self._stream.encode(frame))

    def finish(self) -> None:
        """Complete the file."""
        self._container.mux(self._stream.encode(None))
        self._container.close()

    def take(self) -> bytes:
        """The part of the file that there is since this was last called."""
        return self._collected.take()


class Recorder:
    """Takes a picture whenever one is due.

    A fault ends the recording, and not the simulation: it is told with what there is of the file.

    Args:
        look: Takes a picture.
        encoder: Makes the film of them.
        rate: Pictures per second of simulated time [Hz], one of `RATES`.
    """

    def __init__(self, look: Callable[[], Picture], encoder: Encoder, rate: int) -> None:
        self._look = look
        self._encoder = encoder
        self._every = round(1.0 / rate / TICK)
        self._ticks = 0
        self.error = ""

    def tick(self) -> None:
        """Called in each tick, and once at the start."""
        if self._ticks % self._every == 0:
            self._guard(lambda: self._encoder.add(self._look()))
        self._ticks += 1

    def finish(self) -> None:
        """Complete the film."""
        self._guard(self._encoder.finish)

    def take(self) -> bytes:
        """The part of the file that there is since this was last called."""
        return self._encoder.take()

    def _guard(self, act: Callable[[], None]) -> None:
        if self.error:
            return
        try:
            act()
        except Exception as error:  # of the encoder, of drawing, or of what is looked at
            log.exception("fault while recording")
            self.error = f"{type(error).__name__}: {error}"
