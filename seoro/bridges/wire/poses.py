"""Poses that a world has names for: to spawn at, to drive to, to look from."""

from __future__ import annotations

from seoro.bridges.wire.filters import Bounds, TagsFilter
from seoro.bridges.wire.geometry import Pose
from seoro.bridges.wire.message import Message, Verb


class NamedPose(Message):
    """A pose with a name; `description` is for people, tags say what it is for."""

    name: str
    description: str
    tags: tuple[str, ...]
    pose: Pose


class NamedPoses(Message):
    """Named poses, in the order of the world's file."""

    poses: tuple[NamedPose, ...]


class PoseName(Message):
    """A named pose by name."""

    name: str


class NamedPoseBounds(Message):
    """How much room there is at a named pose, along its own axes; None where the world does not say."""

    bounds: Bounds | None


GET_NAMED_POSES = Verb("get_named_poses", TagsFilter, NamedPoses)
GET_NAMED_POSE_BOUNDS = Verb("get_named_pose_bounds", PoseName, NamedPoseBounds)
