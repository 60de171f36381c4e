"""Video recording of a simulation: the whole world, one of its cameras, or a camera that follows a robot."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from seoro.bridges.wire import StartRecording
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.cameras import render
from sim_nodes.entities import Entities
from sim_nodes.geometry import Vector
from sim_nodes.physics import Engine
from sim_nodes.refusals import feature_unsupported, incorrect_state, operation_failed
from sim_nodes.video import RATES, Encoder, NoVideo, Recorder
from sim_nodes.views import MAX_SIZE, MIN_SIZE, Lens, Picture, View, looking_at, overview
from sim_nodes.worlds.loader import World

BEHIND: Vector = (-1.2, -1.8, 2.2)  # [m] from the followed entity to the camera, along the axes of `map`
LOWEST = 0.5  # [m] height of a world without walls
ARM_HEIGHT, ARM_REACH = 1.3, 0.4  # [m] visible height above the base of an arm, and radius around it

ViewSource = Callable[[], View]


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
        try:
            encoder = Encoder(lens.width, lens.height, request.rate)
        except NoVideo as error:
            raise feature_unsupported(f"cannot record: {error}") from error
        self._recorder = Recorder(_Renderer(self._engine, view_source), encoder, request.rate)
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
        height = max((wall.height for wall in self._world.walls), default=LOWEST)
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
        return self._recorder.drain(), self._recorder.error

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


class _Renderer:
    """Renders images; if the camera or entity was deleted, from the last view."""

    def __init__(self, engine: Engine, view_source: ViewSource) -> None:
        self._engine = engine
        self._view_source = view_source
        self._view = view_source()

    def __call__(self) -> Picture:
        with suppress(RequestRefused):  # the camera or the followed entity was deleted
            self._view = self._view_source()
        return render(self._engine, self._view)
