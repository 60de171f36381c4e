"""Cameras and their pictures. Free ones are entities: `set_entity_state` moves, `delete_entity` deletes them."""

from __future__ import annotations

from seoro.bridges.wire.entities import EntityName
from seoro.bridges.wire.geometry import Pose, Vector3
from seoro.bridges.wire.limits import BYTES
from seoro.bridges.wire.message import Empty, Message, Verb


class SpawnCamera(Message):
    """Spawn a free camera, which looks along the x axis of its pose, with z up."""

    name: str
    pose: Pose
    fov: float  # vertical [rad]
    width: int  # [pixels]
    height: int


class AimCamera(Message):
    """Turn a free camera where it is, so that `target` is in the middle of its pictures."""

    name: str
    target: Vector3


class FollowEntity(Message):
    """Let a free camera go with an entity, at `offset` along the axes of the map [m], and look at it."""

    name: str
    entity: str
    offset: Vector3


class CameraNames(Message):
    """Names of all cameras, sorted; those that robots carry are called `robot/camera`."""

    names: tuple[str, ...]


class CameraImage(Message):
    """What a camera has seen at `time` [s], as PNG; with the faults that the camera has."""

    time: float
    width: int  # [pixels]
    height: int
    data: bytes


SPAWN_CAMERA = Verb("spawn_camera", SpawnCamera, EntityName)
AIM_CAMERA = Verb("aim_camera", AimCamera, Empty)
FOLLOW_ENTITY = Verb("follow_entity", FollowEntity, Empty)
GET_CAMERAS = Verb("get_cameras", Empty, CameraNames)
GET_CAMERA_IMAGE = Verb("get_camera_image", EntityName, CameraImage, answers=BYTES)
