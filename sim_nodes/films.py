"""What is recorded of a simulation: the whole world, one of its cameras, or what follows a robot."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from seoro.bridges.wire import Result, StartRecording
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.cameras import render
from sim_nodes.entities import Entities
from sim_nodes.geometry import Vector
from sim_nodes.physics import Engine
from sim_nodes.video import RATES, Encoder, NoVideo, Recorder
from sim_nodes.views import MAX_SIZE, MIN_SIZE, Lens, Picture, View, looking_at, overview
from sim_nodes.worlds.loader import World

BEHIND: Vector = (-1.2, -1.8, 2.2)  # [m] from what is followed to the camera, along the axes of the map
LOWEST = 0.5  # [m], the height of a world without walls
ARM_HEIGHT, ARM_REACH = 1.3, 0.4  # [m] above the base of an arm and about it, what is to be seen of it

Look = Callable[[], View]


class Films:
    """The recording of a simulation, of which there is one at a time.

    Args:
        engine: What draws.
        world: The world.
        entities: Gives what is in it, which a reset replaces.
    """

    def __init__(self, engine: Engine, world: World, entities: Callable[[], Entities]) -> None:
        self._engine = engine
        self._world = world
        self._entities = entities
        self._recorder: Recorder | None = None

    @property
    def is_recording(self) -> bool:
        """Whether a film is being recorded, which needs every tick."""
        return self._recorder is not None

    def start(self, request: StartRecording) -> None:
        """Start to record.

        Raises:
            RequestRefused: Something is recorded already, there is nothing to look at, or no way to do it.
        """
        if self._recorder is not None:
            raise RequestRefused(Result.INCORRECT_STATE, "a film is being recorded already: stop it first")
        if request.rate not in RATES:
            rates = ", ".join(map(str, RATES))
            raise RequestRefused(
                Result.OPERATION_FAILED, f"{request.rate} pictures a second are not possible: {rates} are"
            )
        look = self._look(request)
        first = look()
        lens = first.lens
        if lens.width % 2 or lens.height % 2:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"pictures of films have even sizes, not {lens.width} by {lens.height}"
            )
        render(self._engine, first)  # which is refused here rather than found out while time passes
        try:
            encoder = Encoder(lens.width, lens.height, request.rate)
        except NoVideo as error:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"no film can be recorded: {error}") from error
        self._recorder = Recorder(_Pictures(self._engine, look), encoder, request.rate)
        self._recorder.tick()

    def _look(self, request: StartRecording) -> Look:
        """From where pictures are taken."""
        if request.camera and request.follow:
            raise RequestRefused(Result.OPERATION_FAILED, "a film is of a camera or follows something, not both")
        if request.camera:
            return lambda: self._entities().cameras.view(request.camera)
        if not all(MIN_SIZE <= size <= MAX_SIZE for size in (request.width, request.height)):
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"a picture has {MIN_SIZE} to {MAX_SIZE} pixels in each direction, not {request.width} by "
                f"{request.height}",
            )
        lens = Lens(width=request.width, height=request.height)
        if request.follow:
            return lambda: self._behind(request.follow, lens)
        return lambda: self._whole(lens)

    def _behind(self, entity: str, lens: Lens) -> View:
        x, y, z = self._entities().state(entity).position
        place = (x + BEHIND[0], y + BEHIND[1], z + BEHIND[2])
        return View(place, looking_at(place, (x, y, z)), lens)

    def _whole(self, lens: Lens) -> View:
        """A view of the whole world, with all that its arms can do above it."""
        height = max((wall.height for wall in self._world.walls), default=LOWEST)
        reached: list[Vector] = []
        for robot in self._world.robots:
            if robot.declaration.arm is not None:
                x, y, top = robot.pose.x, robot.pose.y, robot.height + ARM_HEIGHT
                reached += [
                    (x + dx, y + dy, top) for dx in (-ARM_REACH, ARM_REACH) for dy in (-ARM_REACH, ARM_REACH)
                ]
        return overview(self._world.extent, height, lens, reached)

    def go_on_in(self, world: World, entities: Callable[[], Entities]) -> None:
        """Go on with another simulation, of this world or another."""
        self._world, self._entities = world, entities

    def tick(self) -> None:
        """Called in each tick of the simulation."""
        if self._recorder is not None:
            self._recorder.tick()

    def take(self) -> tuple[bytes, str]:
        """The next part of the film, and why it has ended, if it has."""
        if self._recorder is None:
            return b"", ""
        return self._recorder.take(), self._recorder.error

    def stop(self) -> tuple[bytes, str]:
        """Stop recording; returns what `take` does.

        Raises:
            RequestRefused: Nothing is recorded.
        """
        if self._recorder is None:
            raise RequestRefused(Result.INCORRECT_STATE, "nothing is recorded")
        self._recorder.finish()
        last = self.take()
        self._recorder = None
        return last


class _Pictures:
    """Takes pictures; of what is gone, from where it was last."""

    def __init__(self, engine: Engine, look: Look) -> None:
        self._engine = engine
        self._look = look
        self._view = look()

    def __call__(self) -> Picture:
        with suppress(RequestRefused):  # the camera was deleted, or what it follows
            self._view = self._look()
        return render(self._engine, self._view)
