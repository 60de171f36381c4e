"""Cameras and their pictures. Free cameras are entities, which `set_entity_state` moves."""

from __future__ import annotations

from seoro.bridges.wire.entities import EntityName
from seoro.bridges.wire.limits import BYTES
from seoro.bridges.wire.message import Empty, Message, Query, Verb
from seoro.robotics.geometry import Pose3D, Position3D


class SpawnCamera(Message):
    """Spawn a free camera that looks along the x axis of its pose, with z up."""

    name: str
    pose: Pose3D
    fov: float  # vertical [rad]
    width: int  # [pixels]
    height: int


class AimCamera(Message):
    """Turn a free camera towards `target`."""

    name: str
    target: Position3D


class FollowEntity(Message):
    """Make a free camera follow and view an entity, at `offset` along the axes of the map [m]."""

    name: str
    entity: str
    offset: Position3D


class CameraNames(Message):
    """Names of all cameras, sorted; cameras on robots are called `robot/camera`."""

    names: tuple[str, ...]


class CameraImage(Message):
    """Picture of a camera at `time` [s], as PNG, with the injected faults of the camera."""

    time: float
    width: int  # [pixels]
    height: int
    data: bytes


SPAWN_CAMERA = Verb("spawn_camera", SpawnCamera, EntityName)
AIM_CAMERA = Verb("aim_camera", AimCamera, Empty)
FOLLOW_ENTITY = Verb("follow_entity", FollowEntity, Empty)
GET_CAMERAS = Query("get_cameras", Empty, CameraNames)
GET_CAMERA_IMAGE = Query("get_camera_image", EntityName, CameraImage, reply_limits=BYTES)
