"""The cameras of a world: free ones, which are put somewhere or follow something, and those that robots carry.

Cameras are nothing to physics: they have no mass, nothing touches them, and pictures leave the state as it is.
Pictures for those who ask for them have the faults that lie on their way; films are an observer's, and have none.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import assert_never

from seoro.bridges.wire import CameraFault, Delay, Freeze, Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.geometry import Quaternion, Vector, multiply, rotation_matrix
from sim_nodes.noise import Noise
from sim_nodes.physics import BodyState, Engine, PlacedRobot
from sim_nodes.sensors.camera_feed import PERIOD, CameraFeed, Exposure, Missing
from sim_nodes.stateful import State, Stateful
from sim_nodes.ticks import TICK
from sim_nodes.views import Lens, NoRendering, Picture, View, looking_at
from sim_nodes.worlds.loader import World

MAX_CAMERAS = 50
NEAREST = 1e-6  # [m] to what a camera looks at
MAX_KEPT = (
    128 * 1024 * 1024
)  # [bytes] of pictures that are kept because of faults; half of what a snapshot may have


@dataclass(frozen=True)
class Standing:
    """In the map."""

    position: Vector
    orientation: Quaternion


@dataclass(frozen=True)
class Following:
    """At an offset from an entity, along the axes of the map, with the entity's origin in the middle."""

    entity: str
    offset: Vector


@dataclass(frozen=True)
class Mounted:
    """At a place in the frame of a robot's link."""

    robot: str
    link: str
    position: Vector
    orientation: Quaternion


Mount = Standing | Following | Mounted


@dataclass(frozen=True)
class Camera:
    """A camera and where it is."""

    lens: Lens
    mount: Mount
    spawned: bool = False  # else of the world's file or of a robot


class Cameras(Stateful):
    """The cameras of a world, by name; those of a robot are called `robot/camera`.

    Args:
        engine: What draws.
        world: The world.
        seed: Seed of the simulation.
    """

    STATE = ("_first", "_cameras", "_feeds")

    def __init__(self, engine: Engine, world: World, seed: int) -> None:
        self._engine = engine
        self._seed = seed
        self._first = {name: _standing(view) for name, view in world.cameras.items()}
        for robot in world.robots:
            self._first |= _cameras_of(robot)
        self.reset()

    def reset(self) -> None:
        """Put every camera back to where it was at first, and clear its faults."""
        self._cameras = dict(self._first)
        self._feeds = {name: self._made_feed(name) for name in self._cameras}

    def restore(self, state: State) -> None:
        """See `Stateful`; cameras come and go, and with them the ways of their pictures."""
        self._cameras = state.values["_cameras"]
        self._feeds = {name: self._made_feed(name) for name in self._cameras}
        super().restore(state)

    def _made_feed(self, name: str) -> CameraFeed:
        look = partial(self._sound_picture, name)
        return CameraFeed(self._cameras[name].lens, look, lambda purpose: Noise(self._seed, f"{name}/{purpose}"))

    def names(self) -> tuple[str, ...]:
        """Names of all cameras, sorted."""
        return tuple(sorted(self._cameras))

    @property
    def free(self) -> frozenset[str]:
        """Names of those that are entities of their own."""
        return frozenset(name for name, camera in self._cameras.items() if not isinstance(camera.mount, Mounted))

    def add(self, name: str, lens: Lens, place: BodyState) -> None:
        """Add a free camera, whose name is checked by `Entities`.

        Raises:
            RequestRefused: There are too many.
        """
        if len(self._cameras) >= MAX_CAMERAS:
            raise RequestRefused(Result.OPERATION_FAILED, f"there are {MAX_CAMERAS} cameras already: delete some")
        self._first[name] = Camera(lens, Standing(place.position, place.orientation), spawned=True)
        self._cameras[name] = self._first[name]
        self._feeds[name] = self._made_feed(name)

    def place(self, name: str, place: BodyState) -> None:
        """Put a free camera somewhere; it follows nothing any more."""
        self._set(name, Standing(place.position, place.orientation))

    def follow(self, name: str, entity: str, offset: Vector) -> None:
        """Let a camera go with an entity, and look at it."""
        if math.hypot(*offset) < NEAREST:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"{name!r} cannot follow {entity!r} from inside: give an offset"
            )
        self._set(name, Following(entity, offset))

    def aim(self, name: str, target: Vector) -> None:
        """Turn a camera where it is, so that a point is in the middle of its pictures."""
        position = self.view(name).position
        if math.dist(position, target) < NEAREST:
            raise RequestRefused(Result.OPERATION_FAILED, f"{name!r} cannot look at the point where it is")
        self._set(name, Standing(position, looking_at(position, target)))

    def _set(self, name: str, mount: Mount) -> None:
        camera = self._camera(name)
        if isinstance(camera.mount, Mounted):
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED, f"{name!r} is fixed to {camera.mount.robot!r}: it cannot be moved"
            )
        self._cameras[name] = replace(camera, mount=mount)

    def remove(self, name: str) -> None:
        """Remove a camera that was spawned.

        Raises:
            RequestRefused: It was not.
        """
        if not self._camera(name).spawned:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"{name!r} belongs to the world: what was spawned can be deleted"
            )
        del self._cameras[name], self._first[name], self._feeds[name]

    def remove_spawned(self) -> None:
        """Remove those that were spawned."""
        for name in [name for name, camera in self._cameras.items() if camera.spawned]:
            self.remove(name)

    def forget(self, entity: str) -> None:
        """An entity is about to be deleted: let what follows it stay where it is."""
        for name, camera in self._cameras.items():
            if isinstance(camera.mount, Following) and camera.mount.entity == entity:
                view = self.view(name)
                self._cameras[name] = replace(camera, mount=Standing(view.position, view.orientation))

    def view(self, name: str) -> View:
        """From where a camera looks now, and how.

        Raises:
            RequestRefused: There is no such camera, or there are no pictures here.
        """
        camera = self._camera(name)
        try:
            position, orientation = self._place_of(camera.mount)
        except NoRendering as error:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"no picture can be taken: {error}") from error
        return View(position, orientation, camera.lens)

    def _place_of(self, mount: Mount) -> tuple[Vector, Quaternion]:
        match mount:
            case Standing(position=position, orientation=orientation):
                return position, orientation
            case Following(entity=entity, offset=offset):
                target = self._engine.body_state(entity).position
                position = _moved(target, offset)
                return position, looking_at(position, target)
            case Mounted(robot=robot, link=link, position=inner, orientation=turned):
                place, orientation = self._engine.link_pose(robot, link)
                offset = (rotation_matrix(orientation) @ inner).tolist()
                return _moved(place, offset), multiply(orientation, turned)
            case _:
                assert_never(mount)

    @property
    def is_busy(self) -> bool:
        """Whether any of them has to do something in every tick."""
        return any(feed.is_busy for feed in self._feeds.values())

    def tick(self, tick: int) -> None:
        """Do what is due in a tick."""
        for feed in self._feeds.values():
            if feed.is_busy:
                feed.pass_tick(tick)

    def feed(self, name: str) -> CameraFeed:
        """The way of a camera's pictures to those who ask for them.

        Raises:
            RequestRefused: There is no such camera.
        """
        self._camera(name)
        return self._feeds[name]

    def picture(self, name: str, tick: int) -> Exposure:
        """What a camera gives now, in a tick.

        Raises:
            RequestRefused: There is no such camera, it gives nothing, or there are no pictures here.
        """
        given = self.feed(name).give(tick)
        if isinstance(given, Missing):
            raise RequestRefused(Result.OPERATION_FAILED, f"no picture of {name!r} has come: {given.value}")
        return given

    def _sound_picture(self, name: str) -> Picture:
        return render(self._engine, self.view(name))

    def check_room(self, name: str, fault: CameraFault) -> None:
        """Refuse a fault for which more pictures would have to be kept than may be.

        Raises:
            RequestRefused: There is no room for them.
        """
        others = (
            _kept(feed.lens, each)
            for other, feed in self._feeds.items()
            for each in feed.faults.values()
            if (other, each.kind) != (name, fault.kind)
        )
        wanted = _kept(self.feed(name).lens, fault)
        left = MAX_KEPT - sum(others)
        if wanted > left:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"{fault.kind} of {name!r} keeps {wanted / 1e6:.0f} MB of pictures, and for those of all cameras "
                f"{left / 1e6:.0f} MB are left: make it shorter, or the pictures smaller",
            )

    def _camera(self, name: str) -> Camera:
        if name not in self._cameras:
            raise RequestRefused(
                Result.NOT_FOUND, f"there is no camera {name!r}: known are {listed(self._cameras)}"
            )
        return self._cameras[name]


def render(engine: Engine, view: View) -> Picture:
    """What is seen from a view now.

    Raises:
        RequestRefused: There are no pictures here.
    """
    try:
        return engine.render(view)
    except NoRendering as error:
        raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"no picture can be taken: {error}") from error


def _kept(lens: Lens, fault: CameraFault) -> int:
    """How much of pictures is kept because of a fault [bytes]."""
    match fault:
        case Delay(time=time):
            pictures = math.ceil(time / (PERIOD * TICK)) + 2
        case Freeze():
            pictures = 1
        case _:
            pictures = 0
    return pictures * lens.width * lens.height * 3


def png(picture: Picture) -> bytes:
    """A picture as PNG."""
    from PIL import Image  # noqa: PLC0415 - for nodes that are asked for pictures only

    file = io.BytesIO()
    Image.fromarray(picture).save(file, format="PNG")
    return file.getvalue()


def _standing(view: View) -> Camera:
    return Camera(view.lens, Standing(view.position, view.orientation))


def _cameras_of(robot: PlacedRobot) -> Iterable[tuple[str, Camera]]:
    for camera in robot.declaration.cameras:
        mount = Mounted(robot.name, camera.link, camera.position, camera.orientation)
        yield f"{robot.name}/{camera.name}", Camera(camera.lens, mount)


def _moved(place: Vector, offset: Iterable[float]) -> Vector:
    x, y, z = (at + by for at, by in zip(place, offset, strict=True))
    return x, y, z
