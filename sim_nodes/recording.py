"""Video recording of a simulation: the whole world, one of its cameras, or a camera that follows a robot.

Images are taken at equal steps of simulated time. The MP4 is fragmented: its header is followed by pieces of a
second each, so that the recording of a killed run is playable. The pieces are kept until they are collected, not
written.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from typing import Any

from seoro.bridges.wire import StartRecording
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.cameras import render
from sim_nodes.entities import Entities
from sim_nodes.geometry import Vector
from sim_nodes.outcomes import feature_unsupported, incorrect_state, operation_failed
from sim_nodes.physics import Engine
from sim_nodes.ticks import TICK
from sim_nodes.views import MAX_SIZE, MIN_SIZE, Lens, Picture, View, looking_at, overview
from sim_nodes.worlds.loader import World

RATES = (1, 2, 5, 10, 25, 50)  # [Hz]; images are taken in ticks
MAX_KEPT = 32 * 1024 * 1024  # [bytes] of a video that is not collected; about an hour
QUALITY = "23"  # x264's constant rate factor; lower is better, 23 is the default
FLAGS = "frag_keyframe+empty_moov+default_base_moof"

log = logging.getLogger(__name__)

ViewSource = Callable[[], View]


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
        RequestRefused: The encoder is missing.
    """

    def __init__(self, width: int, height: int, rate: int) -> None:
        try:
            import av  # noqa: PLC0415 - optional, and large
        except ImportError as error:
            raise feature_unsupported("cannot record: videos need PyAV: pip install 'seoro[video]'") from error
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
        engine: Engine that renders.
        view_source: Returns the view of an image; if its camera or entity was deleted, the last view is used.
        encoder: Encodes the video.
        rate: Images per second of simulated time [Hz], one of `RATES`.
    """

    def __init__(self, engine: Engine, view_source: ViewSource, encoder: Encoder, rate: int) -> None:
        self._engine = engine
        self._view_source = view_source
        self._view = view_source()
        self.encoder = encoder
        self._every = round(1.0 / rate / TICK)
        self._ticks = 0
        self.error = ""

    def tick(self) -> None:
        """Update with a tick, also once at the start."""
        if self._ticks % self._every == 0:
            self._guard(self._add_image)
        self._ticks += 1

    def _add_image(self) -> None:
        with suppress(RequestRefused):  # the camera or the followed entity was deleted
            self._view = self._view_source()
        self.encoder.add(render(self._engine, self._view))

    def finish(self) -> None:
        """Complete the video."""
        self._guard(self.encoder.finish)

    def _guard(self, act: Callable[[], None]) -> None:
        if self.error:
            return
        try:
            act()
        except Exception as error:  # of the encoder, the renderer, or the view
            log.exception("error while recording")
            self.error = f"{type(error).__name__}: {error}"


BEHIND: Vector = (-1.2, -1.8, 2.2)  # [m] from the followed entity to the camera, along the axes of `map`
LOWEST = 0.5  # [m] height of a world without walls
ARM_HEIGHT, ARM_REACH = 1.3, 0.4  # [m] visible height above the base of an arm, and radius around it


class Recording:
    """The video recording of a simulation; one at a time.

    Args:
        engine: Engine that renders.
        world: The world.
        entities: Returns its entities, which a reset replaces.
    """

    def __init__(self, engine: Engine, world: World, entities: Callable[[], Entities]) -> None:
        self._engine = engine
        self._world = world
        self._entities = entities
        self._recorder: Recorder | None = None

    @property
    def is_recording(self) -> bool:
        """Whether a recording is active; it needs every tick."""
        return self._recorder is not None

    def start(self, request: StartRecording) -> None:
        """Start a recording.

        Raises:
            RequestRefused: A recording is active, the request is invalid, or rendering or encoding is impossible.
        """
        if self._recorder is not None:
            raise incorrect_state("a recording is active; stop it first")
        if request.rate not in RATES:
            rates = ", ".join(map(str, RATES))
            raise operation_failed(f"unsupported rate of {request.rate} images per second; expected {rates}")
        view_source = self._view_source(request)
        first = view_source()
        lens = first.lens
        if lens.width % 2 or lens.height % 2:
            raise operation_failed(f"odd video size {lens.width} by {lens.height}; expected even numbers")
        render(self._engine, first)  # refuse now rather than fail while time passes
        encoder = Encoder(lens.width, lens.height, request.rate)
        self._recorder = Recorder(self._engine, view_source, encoder, request.rate)
        self._recorder.tick()

    def _view_source(self, request: StartRecording) -> ViewSource:
        """Return the function that computes the view of an image."""
        if request.camera and request.follow:
            raise operation_failed("expected a camera or an entity to follow, not both")
        if request.camera:
            return lambda: self._entities().cameras.view(request.camera)
        if not all(MIN_SIZE <= size <= MAX_SIZE for size in (request.width, request.height)):
            raise operation_failed(
                f"invalid image size {request.width} by {request.height}; expected {MIN_SIZE} to {MAX_SIZE} pixels"
            )
        lens = Lens(width=request.width, height=request.height)
        if request.follow:
            return lambda: self._behind(request.follow, lens)
        return lambda: self._whole(lens)

    def _behind(self, entity: str, lens: Lens) -> View:
        x, y, z = self._entities().state(entity).position
        position = (x + BEHIND[0], y + BEHIND[1], z + BEHIND[2])
        return View(position, looking_at(position, (x, y, z)), lens)

    def _whole(self, lens: Lens) -> View:
        """Return a view of the whole world, including the space above arms."""
        height = max((wall.z + wall.height for wall in self._world.walls), default=LOWEST)
        reached: list[Vector] = []
        for robot in self._world.robots:
            if robot.declaration.arm is not None:
                x, y, top = robot.pose.x, robot.pose.y, robot.height + ARM_HEIGHT
                reached += [
                    (x + dx, y + dy, top) for dx in (-ARM_REACH, ARM_REACH) for dy in (-ARM_REACH, ARM_REACH)
                ]
        return overview(self._world.extent, height, lens, reached)

    def switch_to(self, world: World, entities: Callable[[], Entities]) -> None:
        """Continue the recording in another simulation, of this world or another."""
        self._world, self._entities = world, entities

    def tick(self) -> None:
        """Update with a tick of the simulation."""
        if self._recorder is not None:
            self._recorder.tick()

    def drain(self) -> tuple[bytes, str]:
        """Return the next part of the video, and the error that ended it, if any."""
        if self._recorder is None:
            return b"", ""
        return self._recorder.encoder.drain(), self._recorder.error

    def stop(self) -> tuple[bytes, str]:
        """Stop recording; returns the result of `drain`.

        Raises:
            RequestRefused: No recording is active.
        """
        if self._recorder is None:
            raise incorrect_state("no recording is active")
        self._recorder.finish()
        last = self.drain()
        self._recorder = None
        return last
