"""Contract of backends that have cameras."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from seoro.lang.frozen import Value
from seoro.robotics.geometry import Pose3D, Position3D


class Image(Value):
    """A picture as PNG, with its time [s] and size [pixels]."""

    time: float
    width: int
    height: int
    png: bytes


@runtime_checkable
class Cameras(Protocol):
    """Cameras. Free cameras can be moved; cameras of a robot are named `robot/camera`."""

    async def spawn_camera(self, name: str, pose: Pose3D, fov: float, width: int, height: int) -> str:
        """Spawn a free camera that looks along the x axis of its pose; return its actual name.

        Args:
            name: Requested name.
            pose: Its pose in the map.
            fov: Vertical field of view [rad].
            width: Width of its pictures [pixels].
            height: Height of its pictures [pixels].
        """
        ...

    async def cameras(self) -> tuple[str, ...]:
        """Return the names of all cameras."""
        ...

    async def place_camera(self, name: str, pose: Pose3D) -> None:
        """Set the pose of a free camera; it stops following."""
        ...

    async def aim_camera(self, name: str, target: Position3D) -> None:
        """Turn a free camera in place so that a point is in the middle of its pictures."""
        ...

    async def follow_entity(self, name: str, entity: str, offset: Position3D) -> None:
        """Make a free camera follow an entity at an offset along the axes of the map, and look at it."""
        ...

    async def delete_camera(self, name: str) -> None:
        """Delete a spawned camera."""
        ...

    async def take_picture(self, name: str) -> Image:
        """Take a picture, subject to injected faults. Refused if a fault suppresses the picture."""
