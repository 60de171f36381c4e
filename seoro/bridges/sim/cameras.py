"""Cameras; see `Cameras`."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.sensors import Image

PICTURE_TIMEOUT = 30.0  # [s] of the machine's clock; the first picture loads the renderer


class CameraRequests(Requests):
    """The capability `Cameras` of a node."""

    async def spawn_camera(self, name: str, pose: Pose3D, fov: float, width: int, height: int) -> str:
        """See `Cameras`."""
        request = wire.SpawnCamera(name=name, pose=pose, fov=fov, width=width, height=height)
        return (await self.ask(wire.SPAWN_CAMERA, request)).name

    async def cameras(self) -> tuple[str, ...]:
        """See `Cameras`."""
        return (await self.ask(wire.GET_CAMERAS, wire.Empty())).names

    async def place_camera(self, name: str, pose: Pose3D) -> None:
        """See `Cameras`."""
        await self.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=name, pose=pose))

    async def aim_camera(self, name: str, target: Position3D) -> None:
        """See `Cameras`."""
        await self.ask(wire.AIM_CAMERA, wire.AimCamera(name=name, target=target))

    async def follow_entity(self, name: str, entity: str, offset: Position3D) -> None:
        """See `Cameras`."""
        request = wire.FollowEntity(name=name, entity=entity, offset=offset)
        await self.ask(wire.FOLLOW_ENTITY, request)

    async def delete_camera(self, name: str) -> None:
        """See `Cameras`."""
        await self.ask(wire.DELETE_ENTITY, wire.EntityName(name=name))

    async def take_picture(self, name: str) -> Image:
        """See `Cameras`."""
        found = await self.ask(wire.GET_CAMERA_IMAGE, wire.EntityName(name=name), PICTURE_TIMEOUT)
        return Image(found.time, found.width, found.height, found.data)
