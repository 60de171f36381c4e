"""Cameras of a world: free cameras, at a fixed pose or following an entity, and cameras mounted on robots.

Cameras have no mass and no collision shape, and rendering does not change the state. Faults affect the images that
clients request; recordings show the truth.
"""

from __future__ import annotations

import io
import math
from dataclasses import replace
from typing import assert_never

import numpy as np
from numpy.typing import ArrayLike

from seoro.bridges.wire import CameraFault, Delay, Freeze
from seoro.deferred import dataclass
from sim_nodes.geometry import Quaternion, Vector, compose_frames, vector
from sim_nodes.noise import Noise
from sim_nodes.outcomes import feature_unsupported, operation_failed, unknown
from sim_nodes.physics import BodyState, Engine
from sim_nodes.sensors.camera_pipeline import PERIOD, CameraPipeline, Missing
from sim_nodes.sensors.sensor_pipeline import Sample
from sim_nodes.stateful import State, Stateful
from sim_nodes.ticks import TICK
from sim_nodes.views import TEST_LENS, Lens, NoRendering, Picture, View, looking_at
from sim_nodes.worlds.loader import World

MAX_CAMERAS = 50
NEAREST = 1e-6  # [m] minimum distance of the point that a camera looks at
MAX_KEPT = 128 * 1024 * 1024  # [bytes] of images kept for faults; half of the limit of a snapshot


@dataclass(frozen=True)
class Following:
    """An offset from an entity along the axes of `map`, looking at the entity's origin."""

    entity: str
    offset: Vector


@dataclass(frozen=True)
class Mounted:
    """A pose in the frame of a robot's link."""

    robot: str
    link: str
    position: Vector
    orientation: Quaternion


Mount = BodyState | Following | Mounted
"""A fixed pose in `map`, or one that follows from an entity or a link."""


@dataclass(frozen=True)
class Camera:
    """A camera and its mount."""

    lens: Lens
    mount: Mount
    spawned: bool = False  # otherwise part of the world file or of a robot


class Cameras(Stateful):
    """The cameras of a world by name; those of robots are named `robot/camera`.

    Args:
        engine: Engine that renders.
        world: The world.
        seed: Seed of the simulation.
    """

    STATE = ("_first", "_cameras", "_pipelines")

    def __init__(self, engine: Engine, world: World, seed: int) -> None:
        self._engine = engine
        self._seed = seed
        self._first = {
            name: Camera(view.lens, BodyState(view.position, view.orientation))
            for name, view in world.cameras.items()
        }
        for robot in world.robots:
            for camera in robot.declaration.cameras:
                mount = Mounted(robot.name, camera.link, camera.position, camera.orientation)
                self._first[f"{robot.name}/{camera.name}"] = Camera(camera.lens, mount)
        self.reset()

    def reset(self) -> None:
        """Return every camera to its initial mount and clear its faults."""
        self._cameras = dict(self._first)
        self._pipelines = {name: self._make_pipeline(name) for name in self._cameras}

    def restore(self, state: State) -> None:
        """See `Stateful`; the set of cameras may differ, and with it the pipelines."""
        self._cameras = state.values["_cameras"]
        self._pipelines = {name: self._make_pipeline(name) for name in self._cameras}
        super().restore(state)

    def _make_pipeline(self, name: str) -> CameraPipeline:
        return CameraPipeline(
            self._cameras[name].lens,
            lambda: render(self._engine, self.view(name)),
            lambda purpose: Noise(self._seed, f"{name}/{purpose}"),
        )

    def names(self) -> tuple[str, ...]:
        """Return the names of all cameras, sorted."""
        return tuple(sorted(self._cameras))

    @property
    def free(self) -> frozenset[str]:
        """Names of the free cameras, which are entities."""
        return frozenset(name for name, camera in self._cameras.items() if not isinstance(camera.mount, Mounted))

    def add(self, name: str, lens: Lens, place: BodyState) -> None:
        """Add a free camera; `Entities` has checked its name.

        Raises:
            RequestRefused: There are too many cameras.
        """
        if len(self._cameras) >= MAX_CAMERAS:
            raise operation_failed(f"too many cameras: {MAX_CAMERAS} at most; delete some")
        self._first[name] = Camera(lens, place, spawned=True)
        self._cameras[name] = self._first[name]
        self._pipelines[name] = self._make_pipeline(name)

    def follow(self, name: str, entity: str, offset: Vector) -> None:
        """Make a camera follow an entity and look at it."""
        if math.hypot(*offset) < NEAREST:
            raise operation_failed(f"{name!r} cannot follow {entity!r} at its origin; expected an offset")
        self.set_mount(name, Following(entity, offset))

    def aim(self, name: str, target: Vector) -> None:
        """Turn a camera in place, so that a point is in the middle of its images."""
        position = self.view(name).position
        if math.dist(position, target) < NEAREST:
            raise operation_failed(f"{name!r} cannot look at its own position")
        self.set_mount(name, BodyState(position, looking_at(position, target)))

    def set_mount(self, name: str, mount: Mount) -> None:
        """Set the mount of a free camera.

        Raises:
            RequestRefused: The camera is unknown or mounted on a robot.
        """
        camera = self._camera(name)
        if isinstance(camera.mount, Mounted):
            raise feature_unsupported(f"{name!r} is mounted on {camera.mount.robot!r} and cannot be moved")
        self._cameras[name] = replace(camera, mount=mount)

    def remove(self, name: str) -> None:
        """Remove a spawned camera.

        Raises:
            RequestRefused: The camera was not spawned.
        """
        if not self._camera(name).spawned:
            raise operation_failed(f"{name!r} belongs to the world; only spawned cameras can be deleted")
        del self._cameras[name], self._first[name], self._pipelines[name]

    def remove_spawned(self) -> None:
        """Remove all spawned cameras."""
        for name in [name for name, camera in self._cameras.items() if camera.spawned]:
            self.remove(name)

    def unfollow(self, entity: str) -> None:
        """Stop following an entity that is about to be deleted; its cameras stay where they are."""
        for name, camera in self._cameras.items():
            if isinstance(camera.mount, Following) and camera.mount.entity == entity:
                view = self.view(name)
                self._cameras[name] = replace(camera, mount=BodyState(view.position, view.orientation))

    def view(self, name: str) -> View:
        """Return the present pose and lens of a camera.

        Raises:
            RequestRefused: The camera is unknown, or the engine does not render.
        """
        camera = self._camera(name)
        try:
            position, orientation = self._pose_of(camera.mount)
        except NoRendering as error:
            raise feature_unsupported(f"cannot render: {error}") from error
        return View(position, orientation, camera.lens)

    def _pose_of(self, mount: Mount) -> tuple[Vector, Quaternion]:
        match mount:
            case BodyState(position=position, orientation=orientation):
                return position, orientation
            case Following(entity=entity, offset=offset):
                target = self._engine.body_state(entity).position
                position = _moved(target, offset)
                return position, looking_at(position, target)
            case Mounted(robot=robot, link=link, position=inner, orientation=turned):
                return compose_frames(self._engine.link_pose(robot, link), (inner, turned))
            case _:
                assert_never(mount)

    @property
    def is_busy(self) -> bool:
        """Whether a camera needs every tick."""
        return any(pipeline.is_busy for pipeline in self._pipelines.values())

    def tick(self, tick: int) -> None:
        """Update the pipelines."""
        for pipeline in self._pipelines.values():
            if pipeline.is_busy:
                pipeline.update(tick)

    def pipeline(self, name: str) -> CameraPipeline:
        """Return the pipeline of a camera's images.

        Raises:
            RequestRefused: The camera is unknown.
        """
        self._camera(name)
        return self._pipelines[name]

    def picture(self, name: str, tick: int) -> Sample[Picture]:
        """Return the image that a camera gives in a tick.

        Raises:
            RequestRefused: The camera is unknown, gives no image, or the engine does not render.
        """
        given = self.pipeline(name).give(tick)
        if isinstance(given, Missing):
            raise operation_failed(f"no image from {name!r}: {given.value}")
        return given

    def given(self, name: str, tick: int) -> Sample[Picture] | None:
        """Return the image that a camera gives in a tick; None if it is unknown or gives none."""
        if name not in self._cameras:
            return None
        given = self._pipelines[name].give(tick)
        return None if isinstance(given, Missing) else given

    def check(self, name: str) -> None:
        """Refuse a camera that is unknown or cannot be rendered.

        Raises:
            RequestRefused: The message names the reason.
        """
        render(self._engine, replace(self.view(name), lens=TEST_LENS))

    def check_memory(self, name: str, fault: CameraFault) -> None:
        """Refuse a fault that would exceed the memory for kept images.

        Raises:
            RequestRefused: The memory is too small.
        """
        others = (
            _kept(pipeline.lens, each)
            for other, pipeline in self._pipelines.items()
            for each in pipeline.faults.values()
            if (other, each.kind) != (name, fault.kind)
        )
        wanted = _kept(self.pipeline(name).lens, fault)
        left = MAX_KEPT - sum(others)
        if wanted > left:
            raise operation_failed(
                f"{fault.kind} of {name!r} keeps {wanted / 1e6:.0f} MB of images; only "
                f"{left / 1e6:.0f} MB are left: shorten the fault or reduce the resolution"
            )

    def _camera(self, name: str) -> Camera:
        if name not in self._cameras:
            raise unknown(f"camera {name!r}", "cameras", self._cameras)
        return self._cameras[name]


def render(engine: Engine, view: View) -> Picture:
    """Render a view of the present state.

    Raises:
        RequestRefused: The engine does not render.
    """
    try:
        return engine.render(view)
    except NoRendering as error:
        raise feature_unsupported(f"cannot render: {error}") from error


def _kept(lens: Lens, fault: CameraFault) -> int:
    """Return the memory that a fault needs for kept images [bytes]."""
    match fault:
        case Delay(time=time):
            pictures = math.ceil(time / (PERIOD * TICK)) + 2
        case Freeze():
            pictures = 1
        case _:
            pictures = 0
    return pictures * lens.width * lens.height * 3


def png(picture: Picture) -> bytes:
    """Encode an image as PNG."""
    from PIL import Image  # noqa: PLC0415 - for nodes that are asked for pictures only

    file = io.BytesIO()
    Image.fromarray(picture).save(file, format="PNG")
    return file.getvalue()


def _moved(position: Vector, offset: ArrayLike) -> Vector:
    return vector(np.add(position, offset))
